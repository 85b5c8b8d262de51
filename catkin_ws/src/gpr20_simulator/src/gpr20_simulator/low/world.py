"""The truth about the simulated robot, shared by the processes that simulate its parts.

A small file in shared memory holds one 64-bit word per fact. Each word has one writer, so
a reader sees a new value as soon as the writer has stored it, without any message.
"""

from __future__ import annotations

import enum
import fcntl
import mmap
import os
import tempfile
import time
from pathlib import Path
from typing import Mapping, Optional

from gpr20_common.errors import Gpr20Error

LAYOUT = 0x47505232_00000002
WORD_BYTES = 8


class WorldError(Gpr20Error, OSError):
    """The shared record of the truth cannot be used."""


class AxisName(enum.Enum):
    """The three axes of the robot."""

    X = "x"
    Y = "y"
    Z = "z"


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


class _Word(enum.IntEnum):
    LAYOUT = 0
    X_STEPS = 1
    Y_STEPS = 2
    Z_STEPS = 3
    X_LAST_PULSE_NS = 4
    Y_LAST_PULSE_NS = 5
    Z_LAST_PULSE_NS = 6
    X_ENDSTOP_FAULT = 7
    Y_ENDSTOP_FAULT = 8
    ADC_FAULT = 9
    VNA_PORT = 10
    X_LEVELS = 11
    Y_LEVELS = 12
    Z_LEVELS = 13


_STEPS = {AxisName.X: _Word.X_STEPS, AxisName.Y: _Word.Y_STEPS, AxisName.Z: _Word.Z_STEPS}
_LAST_PULSE = {
    AxisName.X: _Word.X_LAST_PULSE_NS,
    AxisName.Y: _Word.Y_LAST_PULSE_NS,
    AxisName.Z: _Word.Z_LAST_PULSE_NS,
}
_LEVELS = {AxisName.X: _Word.X_LEVELS, AxisName.Y: _Word.Y_LEVELS, AxisName.Z: _Word.Z_LEVELS}
_ENDSTOP_FAULT = {AxisName.X: _Word.X_ENDSTOP_FAULT, AxisName.Y: _Word.Y_ENDSTOP_FAULT}


class World:
    """The shared words, by name. Made by `open_world`."""

    def __init__(self, memory: mmap.mmap) -> None:
        # Stores of an aligned 64-bit item are single instructions: no reader sees half of one.
        self._words = memoryview(memory).cast("q")

    def steps(self, axis: AxisName) -> int:
        """Return where the axis stands [motor steps from coordinate zero]."""
        return self._words[_STEPS[axis]]

    def set_steps(self, axis: AxisName, steps: int) -> None:
        """Put the axis somewhere [motor steps] and note when."""
        self._words[_STEPS[axis]] = steps
        self._words[_LAST_PULSE[axis]] = time.monotonic_ns()

    def last_pulse_ns(self, axis: AxisName) -> int:
        """Return when the axis last moved [ns of time.monotonic_ns()]; 0 if it never did."""
        return self._words[_LAST_PULSE[axis]]

    def pins_low(self, axis: AxisName) -> bool:
        """Return whether the step and direction pins of the axis are both low."""
        return self._words[_LEVELS[axis]] == 0

    def set_pin_levels(self, axis: AxisName, step_high: bool, dir_high: bool) -> None:
        """Note the levels of the step and direction pins of the axis."""
        self._words[_LEVELS[axis]] = step_high | dir_high << 1

    def endstop_fault(self, axis: AxisName) -> EndstopFault:
        """Return the fault of the axis's endstop; an axis without endstop has none."""
        return EndstopFault(self._words[_ENDSTOP_FAULT[axis]] if axis in _ENDSTOP_FAULT else 0)

    def set_endstop_fault(self, axis: AxisName, fault: EndstopFault) -> None:
        """Break or mend the endstop of the x or y axis."""
        if axis not in _ENDSTOP_FAULT:
            raise WorldError(f"the {axis.value} axis has no endstop that could fail")
        self._words[_ENDSTOP_FAULT[axis]] = fault

    @property
    def adc_fault(self) -> AdcFault:
        """The fault of the height sensor's converter."""
        return AdcFault(self._words[_Word.ADC_FAULT])

    @adc_fault.setter
    def adc_fault(self, fault: AdcFault) -> None:
        self._words[_Word.ADC_FAULT] = fault

    @property
    def vna_port(self) -> int:
        """TCP port of the simulated VNA's core channel on loopback; 0 until it listens."""
        return self._words[_Word.VNA_PORT]

    @vna_port.setter
    def vna_port(self, port: int) -> None:
        self._words[_Word.VNA_PORT] = port


def open_world(path: Path, start_steps: Mapping[AxisName, int]) -> World:
    """Open the shared record, making it if it is not there yet.

    Whichever process comes first makes it; all of them pass the same start.

    Args:
        path: The file, in memory-backed storage such as /dev/shm.
        start_steps: Where each axis stands when the robot is switched on [motor steps].

    Raises:
        WorldError: The file cannot be made, or is something else.
    """
    try:
        memory = _map(path, start_steps)
        while memory is None:
            memory = _map(path, start_steps)
    except (OSError, ValueError) as error:
        raise WorldError(f"the simulated world {path} cannot be opened: {error}") from error
    words = memoryview(memory).cast("q")
    if len(words) != len(_Word) or words[_Word.LAYOUT] != LAYOUT:
        raise WorldError(f"{path} is not a simulated world of this version; remove it")
    return World(memory)


def _map(path: Path, start_steps: Mapping[AxisName, int]) -> Optional[mmap.mmap]:
    """Map the file, which is made if it is missing; None if it was cleared away meanwhile."""
    _make(path, start_steps)
    with path.open("r+b") as file:
        # Kept by the map until the process ends: `remove_old_worlds` leaves the world alone.
        fcntl.flock(file.fileno(), fcntl.LOCK_SH)
        if not os.fstat(file.fileno()).st_nlink:
            return None
        return mmap.mmap(file.fileno(), 0)


def _make(path: Path, start_steps: Mapping[AxisName, int]) -> None:
    if path.exists():
        return
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    words = [0] * len(_Word)
    words[_Word.LAYOUT] = LAYOUT
    for axis, steps in start_steps.items():
        words[_STEPS[axis]] = steps
    with tempfile.NamedTemporaryFile(dir=path.parent) as complete:
        complete.write(b"".join(word.to_bytes(WORD_BYTES, "little", signed=True) for word in words))
        complete.flush()
        try:
            # A link is made whole or not at all, so nobody opens a half-written world.
            os.link(complete.name, path)
        except FileExistsError:
            return
