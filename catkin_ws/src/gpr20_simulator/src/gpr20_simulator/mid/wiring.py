"""Which pins the motors and endstops of the simulated robot are wired to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Optional

from gpr20_simulator.low.world import AxisName


@dataclass(frozen=True)
class Wiring:
    """Pins of one axis [BOARD numbers]; an axis without endstop has no sensor pin."""

    dir_pin: int
    step_pin: int
    sensor_pin: Optional[int]


# As on the robot. A driver that is configured with other pins moves nothing.
WIRING: Dict[AxisName, Wiring] = {
    AxisName.X: Wiring(dir_pin=13, step_pin=15, sensor_pin=16),
    AxisName.Y: Wiring(dir_pin=37, step_pin=38, sensor_pin=40),
    AxisName.Z: Wiring(dir_pin=11, step_pin=12, sensor_pin=None),
}
