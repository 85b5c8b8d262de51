"""The step count of an axis, in a file that two processes share and that outlives both.

The file is mapped into memory, so a count is there for the other process at once, and stays in
the system's cache when a process is killed. It is locked by whoever drives the axis.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import tempfile
import time
from enum import IntEnum
from pathlib import Path

from gpr20_axis_driver.axis_exceptions import StepCounterError

LAYOUT = 0x47505241_00000001
WORD_BYTES = 8
# All words lie in one sector, which a disk writes whole or not at all.
FILE_BYTES = 512
# What is stored at rest is the count mixed with this: it cannot be true of another count.
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


class StepCounter:
    """The shared words of one axis. One process at a time may change them."""

    def __init__(self, descriptor: int) -> None:
        """Map the open file; made by `open_step_counter`, or from an inherited descriptor."""
        self._descriptor = descriptor
        self._memory = mmap.mmap(descriptor, FILE_BYTES)
        # Stores of an aligned 64-bit item are single instructions: no reader sees half of one.
        self._words = memoryview(self._memory).cast("q")

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
        """Whether the count was exact when the motor last stood, and nothing moved since."""
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
        """How often whoever asked for the motion under way has given a sign of life."""
        return self._words[_Word.BEATS]

    def beat(self) -> None:
        """Give a sign of life."""
        self._words[_Word.BEATS] += 1

    def begin(self) -> None:
        """Trust the count no more, as a motion begins; durable before the first pulse."""
        self._words[_Word.RESTING] = 0
        self._memory.flush()

    def count(self, change: int) -> None:
        """Add to the count [motor steps]."""
        self._words[_Word.STEPS] += change

    def rest(self) -> None:
        """Note that the motor rests and that the count is exact; durable on return."""
        self._words[_Word.RESTING] = self.steps ^ REST_KEY
        self._memory.flush()

    def place(self, steps: int) -> None:
        """Set the count of a motor that rests [motor steps]."""
        # Not trusted in between: no power cut makes a count of two halves.
        self.begin()
        self._words[_Word.STEPS] = steps
        self.rest()

    def check(self, step_size: float) -> None:
        """Forget the count if it was made with steps of another size [mm or deg]."""
        size_nano = round(step_size * NANO)
        if self._words[_Word.STEP_SIZE_NANO] != size_nano:
            self.begin()
            self._words[_Word.STEP_SIZE_NANO] = size_nano
        self.stop_requested = False

    def is_one_of_ours(self) -> bool:
        """Return whether the file is a step count of this version."""
        return self._words[_Word.LAYOUT] == LAYOUT

    def close(self) -> None:
        """Release the file."""
        self._words.release()
        self._memory.close()
        os.close(self._descriptor)


def open_step_counter(path: Path, step_size: float, lock_limit_s: float) -> StepCounter:
    """Open and lock the file, making it if it is not there yet; a new one is not trusted.

    Args:
        path: The file.
        step_size: What one step is [mm or deg].
        lock_limit_s: How long to wait while another process holds the axis [s].

    Raises:
        StepCounterError: The file is held by another process, is something else, or
            cannot be used.
    """
    try:
        _make(path)
        descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    except OSError as error:
        raise StepCounterError(
            f"the step count cannot be kept in {path}: {error.strerror}; give a memory_file in a "
            "folder that can be written"
        ) from error
    try:
        _lock(path, descriptor, lock_limit_s)
        if os.fstat(descriptor).st_size != FILE_BYTES:
            raise _not_ours(path)
        counter = StepCounter(descriptor)
        if not counter.is_one_of_ours():
            raise _not_ours(path)
    except BaseException:
        os.close(descriptor)
        raise
    counter.check(step_size)
    return counter


def _not_ours(path: Path) -> StepCounterError:
    return StepCounterError(
        f"{path} is not a step count of this version: move it away, then turn the antennas to "
        "their mark and call the service set_zero"
    )


def _lock(path: Path, descriptor: int, limit_s: float) -> None:
    deadline_s = time.monotonic() + limit_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > deadline_s:
                raise StepCounterError(
                    f"another process drives this axis (it holds {path}): end the other "
                    "axis_driver of this axis first"
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
            # A link is made whole or not at all, so nobody opens a half-written file.
            os.link(complete.name, path)
        except FileExistsError:
            return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
