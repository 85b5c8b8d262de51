"""The axes: their names, the frames that they move, and the zeros of their coordinates."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Tuple

# `map` -> `base_link` (the origin of the axes on the ground; x along X, y along Y, z up; metres) ->
# `y_carriage_link` -> `x_carriage_link` -> `antenna_link`, which turns about z, and
# `height_sensor_link`. A robot in a namespace has the same names on its own `tf`.
MAP = "map"
BASE_LINK = "base_link"
Y_CARRIAGE_LINK = "y_carriage_link"
X_CARRIAGE_LINK = "x_carriage_link"
ANTENNA_LINK = "antenna_link"
HEIGHT_SENSOR_LINK = "height_sensor_link"


class AxisId(enum.Enum):
    """The three axes, with the unit of their coordinates."""

    X = "x"
    Y = "y"
    Z = "z"

    @property
    def unit(self) -> str:
        return "deg" if self is AxisId.Z else "mm"


AXES = len(AxisId)


@dataclass(frozen=True)
class ZeroEpoch:
    """One zero of an axis: each homing and each set_zero begins another epoch of its coordinate.

    Coordinates of different zeros are not comparable.

    Attributes:
        number: Grows with each homing and set_zero; 0: not known.
        time_us: When the zero was found or set [us since 1970, UTC], by the axis's computer. An
            axis without endstop turns to its zero in a homing and finds nothing: its time is that
            of the last set_zero.
    """

    number: int = 0
    time_us: int = 0

    @property
    def is_known(self) -> bool:
        """Whether the axis has said which zero it is."""
        return self.number > 0


UNKNOWN_ZERO = ZeroEpoch()
# The zeros of x, y and z; empty: not known, as in traces that were imported.
Zeros = Tuple[ZeroEpoch, ...]
MAX_NUMBER = (1 << 32) - 1
MAX_TIME_US = ((1 << 32) - 1) * 1_000_000


def are_zeros(zeros: Zeros) -> bool:
    """Return whether these can be the zeros of a trace: of each axis, or of none."""
    return len(zeros) in (0, AXES) and all(
        0 < one.number <= MAX_NUMBER and 0 <= one.time_us <= MAX_TIME_US for one in zeros
    )
