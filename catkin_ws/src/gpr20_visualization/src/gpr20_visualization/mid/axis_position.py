"""The position of the axes as joints: metres and radians."""

from __future__ import annotations

import math
from typing import Dict

MM_PER_M = 1000.0
Y_JOINT, X_JOINT, Z_JOINT = "y_axis_joint", "x_axis_joint", "z_axis_joint"
JOINTS = (Y_JOINT, X_JOINT, Z_JOINT)


def joint_positions(x_mm: float, y_mm: float, z_deg: float) -> Dict[str, float]:
    """Return the position of each joint [m or rad].

    Args:
        x_mm: Position along X [mm].
        y_mm: Position along Y [mm].
        z_deg: Rotation of the antennas [deg].
    """
    return {Y_JOINT: y_mm / MM_PER_M, X_JOINT: x_mm / MM_PER_M, Z_JOINT: math.radians(z_deg)}
