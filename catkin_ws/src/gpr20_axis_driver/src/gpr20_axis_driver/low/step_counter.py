"""The step count of an axis, in a file that two processes share and that outlives both.

The file is mapped into memory, so the other process sees a count at once, and the count stays
in the system's cache when a process is killed. The process that drives the axis locks the file.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import tempfile
import time
from enum import IntEnum
from pathlib import Path
from typing import Optional

from gpr20_axis_driver.faults import AxisException
from gpr20_common.errors import os_reason
from gpr20_common.faults import CONFIGURATION, OTHER_LAUNCH
from gpr20_common.message import Message
from gpr20_survey.axes import ZeroEpoch
from gpr20_survey.faults import ZERO_UNKNOWN

LAYOUT = 0x47505241_00000001
WORD_BYTES = 8
# All words lie in one sector, which a disk writes whole or not at all.
FILE_BYTES = 512
# At rest, the count is stored a second time, XOR this key: it cannot match another count.
REST_KEY = 0x5AFE_5E7_0F_57E95
NANO = 1.0e9
LOCK_POLL_S = 0.02


class _Word(IntEnum):
    LAYOUT = 0
    STEP_SIZE_NANO = 1
    STEPS = 2
    RESTING = 3
    STOP = 4
    BEATS = 5
    # 0 before the first reading, 1 open, 2 pressed.
    ENDSTOP = 6
    PRESSES = 7
    ZERO_EPOCH = 8
    ZERO_TIME_US = 9


class StepCounter:
    """The shared words of one axis. One process at a time may change them."""

    def __init__(self, descriptor: int) -> None:
        """Map the open file; made by `open_step_counter`, or from an inherited descriptor."""
        self._descriptor = descriptor
        self._memory = mmap.mmap(descriptor, FILE_BYTES)
        # An aligned 64-bit item is stored by one instruction: no reader sees half of one.
        self._words = memoryview(self._memory).cast("q")
        self._exact = False

    @property
    def descriptor(self) -> int:
        """The open and locked file, to be inherited by the process that makes the pulses."""
        return self._descriptor

    @property
    def steps(self) -> int:
        """The count [motor steps from coordinate zero]."""
        return self._words[_Word.STEPS]

    @property
    def trusted(self) -> bool:
        """Whether the count was exact when the motor last stopped, and nothing moved since.

        A count becomes exact by `place` alone; motions only keep it.
        """
        return self._words[_Word.RESTING] == self.steps ^ REST_KEY

    @property
    def stop_requested(self) -> bool:
        """Whether to end the motion under way."""
        return self._words[_Word.STOP] != 0

    @stop_requested.setter
    def stop_requested(self, requested: bool) -> None:
        self._words[_Word.STOP] = int(requested)

    @property
    def beats(self) -> int:
        """How many beats the parent process has counted."""
        return self._words[_Word.BEATS]

    def beat(self) -> None:
        """Count a beat, which shows that the parent process still runs."""
        self._words[_Word.BEATS] += 1

    @property
    def endstop_pressed(self) -> Optional[bool]:
        """Whether the endstop was pressed when it was last read; None if it was not read yet."""
        reading = self._words[_Word.ENDSTOP]
        return None if reading == 0 else reading == 2

    @property
    def endstop_presses(self) -> int:
        """How many times the endstop has closed, as far as it was read."""
        return self._words[_Word.PRESSES]

    def note_endstop(self, pressed: bool) -> None:
        """Note a reading of the endstop."""
        reading = 1 + pressed
        # Only a change is written: the file may be on a disk.
        if self._words[_Word.ENDSTOP] != reading:
            self._words[_Word.ENDSTOP] = reading
            self._words[_Word.PRESSES] += pressed

    def begin(self) -> None:
        """Mark the count as not trusted, as a motion begins; durable before the first pulse."""
        self._exact = self.trusted
        self._words[_Word.RESTING] = 0
        self._memory.flush()

    def count(self, change: int) -> None:
        """Add to the count [motor steps]."""
        self._words[_Word.STEPS] += change

    def rest(self) -> None:
        """Mark the count as exact again, if it was before the motion; durable on return."""
        if self._exact:
            self._words[_Word.RESTING] = self.steps ^ REST_KEY
            self._memory.flush()

    def place(self, steps: int) -> None:
        """Set the count of a motor that is at rest [motor steps]."""
        # Not trusted in between: a power cut cannot leave a wrong count that is trusted.
        self.begin()
        self._words[_Word.STEPS] = steps
        self._exact = True
        self.rest()

    @property
    def zero(self) -> ZeroEpoch:
        """The zero that the count refers to."""
        return ZeroEpoch(self._words[_Word.ZERO_EPOCH], self._words[_Word.ZERO_TIME_US])

    def begin_zero(self, time_us: int) -> None:
        """Begin another epoch of the zero; the count is not trusted until `place`.

        Args:
            time_us: When the zero was found or set [us since 1970].
        """
        self.begin()
        self._words[_Word.ZERO_EPOCH] += 1
        self._words[_Word.ZERO_TIME_US] = time_us

    def check(self, step_size: float) -> None:
        """Mark the count as not trusted if its steps had another size [mm or deg].

        Raises:
            ValueError: It is not a step count of this version.
        """
        if self._words[_Word.LAYOUT] != LAYOUT:
            raise ValueError("layout")
        size_nano = round(step_size * NANO)
        if self._words[_Word.STEP_SIZE_NANO] != size_nano:
            self.begin()
            self._words[_Word.STEP_SIZE_NANO] = size_nano
        self.stop_requested = False
        self._words[_Word.ENDSTOP] = 0

    def close(self) -> None:
        """Release the file."""
        self._words.release()
        self._memory.close()
        os.close(self._descriptor)


def open_step_counter(path: Path, step_size: float, lock_limit_s: float) -> StepCounter:
    """Open and lock the file, creating it if necessary; a new count is not trusted.

    Args:
        path: The file.
        step_size: What one step is [mm or deg].
        lock_limit_s: How long to wait while another process has locked the file [s].

    Raises:
        AxisException: The file is locked by another process, is not a step count, or
            cannot be used.
    """
    try:
        _make(path)
        descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except OSError as error:
        raise AxisException(
            Message(
                "the step count cannot be stored in {path}: {reason}; set memory_file to a file "
                "in a writable folder",
                path=path,
                reason=os_reason(error),
            ),
            fault=CONFIGURATION,
        ) from error
    try:
        _lock(path, descriptor, lock_limit_s)
        # A file of another length cannot be mapped, or has more behind it.
        if os.fstat(descriptor).st_size != FILE_BYTES:
            raise ValueError("length")
        counter = StepCounter(descriptor)
        counter.check(step_size)
        return counter
    except ValueError as error:
        os.close(descriptor)
        raise AxisException(
            Message(
                "{path} is not a step count of this version; move it away, then turn the antennas "
                "to their mark and set the zero of this axis",
                path=path,
                details="service set_zero",
            ),
            fault=ZERO_UNKNOWN,
        ) from error
    except BaseException:
        os.close(descriptor)
        raise


def _lock(path: Path, descriptor: int, limit_s: float) -> None:
    deadline_s = time.monotonic() + limit_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > deadline_s:
                raise AxisException(
                    Message(
                        "another process drives this axis; end the other driver of this axis first",
                        details=f"it has locked {path}",
                    ),
                    fault=OTHER_LAUNCH,
                ) from None
        time.sleep(LOCK_POLL_S)


def _make(path: Path) -> None:
    if path.exists():
        return
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent) as complete:
        complete.write(LAYOUT.to_bytes(WORD_BYTES, "little").ljust(FILE_BYTES, b"\0"))
        complete.flush()
        os.fsync(complete.fileno())
        try:
            # A link appears complete or not at all, so nobody opens a half-written file.
            os.link(complete.name, path)
        except FileExistsError:
            return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
