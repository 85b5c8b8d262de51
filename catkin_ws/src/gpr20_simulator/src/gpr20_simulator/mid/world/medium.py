"""What the antennas look into, from where; and a medium for tests."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, Tuple

import numpy as np

Y_SCALE = 1000.0
ROTATION_START_DEG = -90.0
ROTATION_SCALE_DEG = 200.0
# Leaves 8 of the 24 bits of a float32 for the rotation.
PROBED_SWEEPS = 1 << 16
# A known point that is measured again agrees at its place, whatever the number of the sweep.
SWEEP_SCALE = 4096.0


@dataclass(frozen=True)
class AntennaPosition:
    """Place and rotation of the antenna pair over the ground.

    Attributes:
        x_mm: Position of the carriage along X [mm].
        y_mm: Position of the carriage along Y [mm].
        rotation_deg: Rotation of the antennas about the vertical [deg].
    """

    x_mm: float
    y_mm: float
    rotation_deg: float


class SweptMedium(Protocol):
    """Anything that has a transmission between the two antennas."""

    def s21(
        self,
        frequency_hz: np.ndarray,
        position: AntennaPosition,
        sweep_number: int,
        noise_gain: float = 1.0,
    ) -> np.ndarray:
        """Return the complex transmission at each frequency [Hz] of a part of a sweep.

        The noise of the receiver is relative to that of the settings of power-on.
        """


class PositionProbe:
    """Answers with the number of the sweep, the position and the rotation, instead of physics.

    The integer part of 4096 times the real part is the number of the sweep, counted from 0 again
    after 65,536 sweeps; its fraction is the rotation, (rotation_deg + 90) / 200, exact to 0.4
    degrees from -90 to 109 degrees. The imaginary part is x_mm + y_mm / 1000: whole millimetres
    can be distinguished exactly (x below 1000, y from 0 to 999), and any movement of 0.01 mm along
    X or 0.1 mm along Y changes it. All this is still so in a float32.
    """

    def s21(
        self,
        frequency_hz: np.ndarray,
        position: AntennaPosition,
        sweep_number: int,
        noise_gain: float = 1.0,
    ) -> np.ndarray:
        """Return the same number for every frequency, without noise."""
        turned = (position.rotation_deg - ROTATION_START_DEG) / ROTATION_SCALE_DEG
        value = complex(
            (sweep_number % PROBED_SWEEPS + turned) / SWEEP_SCALE,
            position.x_mm + position.y_mm / Y_SCALE,
        )
        return np.full(len(frequency_hz), value, dtype=np.complex128)


def probed_sweep(value: complex) -> int:
    """Return the number of the sweep that a value is from, modulo 65,536."""
    return math.floor(value.real * SWEEP_SCALE)


def probed_position_mm(value: complex) -> Tuple[int, int]:
    """Return x and y, both to the whole millimetre, that a value was measured at."""
    thousandths = round(value.imag * Y_SCALE)
    x_mm, y_mm = divmod(thousandths, int(Y_SCALE))
    return x_mm, y_mm


def probed_rotation_deg(value: complex) -> float:
    """Return the rotation, to 0.4 degrees, that a value was measured at [deg]."""
    turned = value.real * SWEEP_SCALE - probed_sweep(value)
    return turned * ROTATION_SCALE_DEG + ROTATION_START_DEG
