"""A medium whose transmission tells which sweep a number is from, and from where."""

from __future__ import annotations

from typing import Tuple

import numpy as np

from gpr20_simulator.mid.antenna_position import AntennaPosition

Y_SCALE = 1000.0


class PositionProbe:
    """Answers with the number of the sweep and the position, instead of physics.

    The real part is the number of the sweep, exact in a float32 up to 16 million. The
    imaginary part is x_mm + y_mm / 1000: whole millimetres can be told apart exactly
    (x below 1000, y from 0 to 999), and any movement of 0.01 mm along X or 0.1 mm along
    Y changes it. The rotation does not appear.
    """

    def s21(
        self, frequency_hz: np.ndarray, position: AntennaPosition, sweep_number: int
    ) -> np.ndarray:
        """Return the same number for every frequency."""
        value = complex(sweep_number, position.x_mm + position.y_mm / Y_SCALE)
        return np.full(len(frequency_hz), value, dtype=np.complex128)


def probed_sweep(value: complex) -> int:
    """Return the number of the sweep that a value is from."""
    return round(value.real)


def probed_position_mm(value: complex) -> Tuple[int, int]:
    """Return x and y, both to the whole millimetre, that a value was measured at."""
    thousandths = round(value.imag * Y_SCALE)
    x_mm, y_mm = divmod(thousandths, int(Y_SCALE))
    return x_mm, y_mm
