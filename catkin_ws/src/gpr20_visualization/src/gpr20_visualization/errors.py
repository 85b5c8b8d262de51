"""What the visualization refuses."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_visualization import faults


class RobotModelError(Gpr20Error, ValueError):
    """The description of the robot (URDF) cannot be used."""

    fault = faults.WRONG_DESCRIPTION
