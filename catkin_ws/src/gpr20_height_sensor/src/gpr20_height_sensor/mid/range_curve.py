"""From the sensor's voltage to a distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.checks import number_between
from gpr20_height_sensor.errors import HeightParameterError

# No sensor of this kind sees as far.
LONGEST_M = 10.0


@dataclass(frozen=True)
class RangeCurve:
    """Distance = scale * (voltage / 1 V) ** -exponent, for a GP2Y0A21YK0F.

    Sharp's data sheet E4-A00201EN gives as typical values 0.4 V at 0.80 m and 1.9 V more
    at 0.10 m, so 2.3 V there. The defaults are the power law through these two points:
    exponent = ln(0.80 / 0.10) / ln(2.3 / 0.4) = 1.188796, scale = 0.80 * 0.4 ** exponent.
    Single sensors differ (0.25 to 0.55 V at 0.80 m): measure two heights with the robot's
    own and set both parameters.

    Attributes:
        scale_m: Distance at 1 V [m].
        exponent: How steeply the distance falls with the voltage.
        min_distance_m: Shortest valid distance [m]; nearer, the voltage falls again.
        max_distance_m: Longest valid distance [m].
    """

    scale_m: float = 0.269166
    exponent: float = 1.188796
    min_distance_m: float = 0.10
    max_distance_m: float = 0.80

    def __post_init__(self) -> None:
        try:
            number_between("scale_m", self.scale_m, 0.001, LONGEST_M, "m")
            number_between("exponent", self.exponent, 0.1, 10.0)
            number_between("min_distance_m", self.min_distance_m, 0.001, LONGEST_M, "m")
            number_between("max_distance_m", self.max_distance_m, 0.001, LONGEST_M, "m")
        except InvalidValueError as error:
            raise HeightParameterError(str(error)) from error
        if not self.min_distance_m < self.max_distance_m:
            raise HeightParameterError(
                f"min_distance_m is {self.min_distance_m:g} m; it must be less than "
                f"max_distance_m, which is {self.max_distance_m:g} m"
            )

    def distances_m(self, voltages_v: np.ndarray) -> np.ndarray:
        """Return the distances [m] at voltages [V]; infinity at zero volts."""
        with np.errstate(divide="ignore"):
            return self.scale_m * np.asarray(voltages_v, dtype=np.float64) ** -self.exponent
