"""What the visualization refuses."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import CONFIGURATION


class RobotModelError(Gpr20Error, ValueError):
    """The description of the robot (URDF) cannot be used."""

    fault = CONFIGURATION
