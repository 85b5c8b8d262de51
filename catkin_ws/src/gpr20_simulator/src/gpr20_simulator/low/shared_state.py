"""The true state of the simulated robot, shared by the processes that simulate its parts; a clock.

A small file in shared memory holds one 64-bit word per fact. Each word has one writer, so
a reader sees a new value as soon as the writer has stored it, without any message.
"""

from __future__ import annotations

import contextlib
import ctypes
import enum
import fcntl
import mmap
import os
import re
import tempfile
import threading
import time
from pathlib import Path
from typing import Mapping, Optional

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_survey.axes import AxisId

INDEX = {axis: index for index, axis in enumerate(AxisId)}
# A shared state that was just made is opened, and a node that died is there again, within this [s].
GRACE_S = 60.0
# A shared state, or the step memory of one of its axes.
NAME = re.compile(r"([0-9a-f]{32})(_[xyz]_steps)?")


class ScaledClock(Clock):
    """Lets `factor` seconds pass in each real second.

    A driver that waits by this clock works unchanged, `factor` times as fast.
    """

    def __init__(self, factor: float) -> None:
        self._factor = factor

    @property
    def factor(self) -> float:
        """How many times faster than the real time this clock runs."""
        return self._factor

    def now_s(self) -> float:
        """Return the scaled time [s] since some fixed moment."""
        return time.monotonic() * self._factor

    def sleep_until_s(self, deadline_s: float) -> None:
        """Return once the scaled time has reached the deadline [s]."""
        remaining_s = deadline_s / self._factor - time.monotonic()
        if remaining_s > 0.0:
            time.sleep(remaining_s)

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        """Wait for the event for at most `timeout_s` scaled seconds."""
        return event.wait(timeout_s / self._factor)


class SharedStateError(Gpr20Error, OSError):
    """The shared state cannot be used."""

    fault = OTHER_LAUNCH


class EndstopFault(enum.IntEnum):
    """What is wrong with an endstop."""

    NONE = 0
    STUCK_OPEN = 1
    STUCK_CLOSED = 2


class AdcFault(enum.IntEnum):
    """What is wrong with the analogue-to-digital converter of the height sensor."""

    NONE = 0
    STUCK = 1
    OUT_OF_RANGE = 2


class _Words(ctypes.Structure):
    """The layout of the file; a store of an aligned word is never seen half done."""

    _PerAxis = ctypes.c_int64 * len(INDEX)
    _fields_ = (
        ("steps", _PerAxis),
        ("last_pulse_ns", _PerAxis),
        ("pin_levels", _PerAxis),
        ("endstop_fault", _PerAxis),
        ("adc_fault", ctypes.c_int64),
        ("vna_port", ctypes.c_int64),
    )


class SharedState:
    """The shared words, by name. Made by `open_shared_state`."""

    def __init__(self, words: _Words) -> None:
        self._words = words

    def steps(self, axis: AxisId) -> int:
        """Return where the axis is [motor steps from coordinate zero]."""
        return self._words.steps[INDEX[axis]]

    def set_steps(self, axis: AxisId, steps: int) -> None:
        """Put the axis somewhere [motor steps] and note when."""
        self._words.steps[INDEX[axis]] = steps
        self._words.last_pulse_ns[INDEX[axis]] = time.monotonic_ns()

    def last_pulse_ns(self, axis: AxisId) -> int:
        """Return when the axis last moved [ns of time.monotonic_ns()]; 0 if it never did."""
        return self._words.last_pulse_ns[INDEX[axis]]

    def pins_low(self, axis: AxisId) -> bool:
        """Return whether the step and direction pins of the axis are both low."""
        return self._words.pin_levels[INDEX[axis]] == 0

    def set_pin_levels(self, axis: AxisId, step_high: bool, dir_high: bool) -> None:
        """Note the levels of the step and direction pins of the axis."""
        self._words.pin_levels[INDEX[axis]] = step_high | dir_high << 1

    def endstop_fault(self, axis: AxisId) -> EndstopFault:
        """Return the fault of the axis's endstop; an axis without endstop has none."""
        return EndstopFault(self._words.endstop_fault[INDEX[axis]])

    def set_endstop_fault(self, axis: AxisId, fault: EndstopFault) -> None:
        """Break or repair the endstop of the x or y axis."""
        self._words.endstop_fault[INDEX[axis]] = fault

    @property
    def adc_fault(self) -> AdcFault:
        """The fault of the height sensor's converter."""
        return AdcFault(self._words.adc_fault)

    @adc_fault.setter
    def adc_fault(self, fault: AdcFault) -> None:
        self._words.adc_fault = fault

    @property
    def vna_port(self) -> int:
        """TCP port of the simulated VNA's core channel on loopback; 0 until it listens."""
        return int(self._words.vna_port)

    @vna_port.setter
    def vna_port(self, port: int) -> None:
        self._words.vna_port = port


def open_shared_state(
    path: Path, start_steps: Optional[Mapping[AxisId, int]] = None
) -> SharedState:
    """Open the shared state, making it if it is not there yet.

    Whichever process comes first makes it; all of them pass the same start.

    Args:
        path: The file, in memory-backed storage such as /dev/shm.
        start_steps: Where each axis is when the robot is switched on [motor steps]; 0 if absent.

    Raises:
        SharedStateError: The file cannot be made, or is something else.
    """
    try:
        memory = None
        while memory is None:
            memory = _map(path, start_steps or {})
        return SharedState(_Words.from_buffer(memory))
    except (OSError, ValueError) as error:
        reason = os_reason(error) if isinstance(error, OSError) else verbatim(str(error))
        raise SharedStateError(
            Message(
                "the simulated robot's file {path} cannot be opened: {reason}; remove it when no "
                "simulated robot runs",
                path=path,
                reason=reason,
            )
        ) from error


def _map(path: Path, start_steps: Mapping[AxisId, int]) -> Optional[mmap.mmap]:
    """Map the file, which is made if it is missing; None if it was cleared away meanwhile."""
    _make(path, start_steps)
    with path.open("r+b") as file:
        # Kept by the map until the process ends: `remove_stale_states` leaves the file alone.
        fcntl.flock(file.fileno(), fcntl.LOCK_SH)
        if not os.fstat(file.fileno()).st_nlink:
            return None
        return mmap.mmap(file.fileno(), 0)


def _make(path: Path, start_steps: Mapping[AxisId, int]) -> None:
    if path.exists():
        return
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    words = _Words()
    for axis, steps in start_steps.items():
        words.steps[INDEX[axis]] = steps
    with tempfile.NamedTemporaryFile(dir=path.parent) as complete:
        complete.write(bytes(words))
        complete.flush()
        try:
            # A link is made whole or not at all, so nobody opens a half-written state.
            os.link(complete.name, path)
        except FileExistsError:
            return


def remove_stale_states(folder: Path) -> None:
    """Remove the shared states that no process has open, with the files beside them.

    Args:
        folder: Where the states of this user are; may be missing.

    Raises:
        OSError: The folder cannot be read, or a file not be removed.
    """
    names = [one.name for one in folder.iterdir()] if folder.is_dir() else []
    known = [match for match in map(NAME.fullmatch, names) if match]
    for state in {match.group(1) for match in known}:
        paths = [folder / match.group() for match in known if match.group(1) == state]
        with contextlib.ExitStack() as held:
            if all(_is_stale(path, held) for path in paths):
                # While the lock is held: who opens the state now sees that it is gone.
                for path in paths:
                    path.unlink()


def _is_stale(path: Path, held: contextlib.ExitStack) -> bool:
    """Return whether a file is old; a state also that nobody has it open, and lock it."""
    try:
        stream = held.enter_context(path.open("rb"))
        is_old = abs(time.time() - os.fstat(stream.fileno()).st_mtime) >= GRACE_S
        # The lock of a step memory belongs to its axis.
        if is_old and "_" not in path.name:
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (FileNotFoundError, BlockingIOError):
        return False  # another launch clears away, too, or a process has it
    return is_old
