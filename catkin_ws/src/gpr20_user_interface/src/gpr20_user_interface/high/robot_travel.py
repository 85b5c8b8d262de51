"""What the axes can do, from their own parameters."""

from __future__ import annotations

import math
from typing import Any, List
from xmlrpc.client import Error as XmlRpcError

import rospy

from gpr20_main_control.mid.survey_parameters import RobotTravel, Travel
from gpr20_user_interface.mid.survey_state import AxisLimits

AXES = ("x", "y", "z")
FIELDS = ("min_coord", "max_coord", "step_size")


def read_axis_limits() -> AxisLimits:
    """Read the limits of the three axes, or why they are not known."""
    travels: List[Travel] = []
    for axis in AXES:
        name = rospy.resolve_name(f"{axis}_axis/axis_driver")
        try:
            group = rospy.get_param(name, {})
        except (rospy.ROSException, XmlRpcError, OSError) as error:
            return AxisLimits(None, f"the ROS master does not answer: {error}")
        values = [_number(group, field) for field in FIELDS]
        if not all(math.isfinite(value) for value in values):
            return AxisLimits(None, f"{name} has no parameters {', '.join(FIELDS)}")
        travels.append(Travel(*values))
    return AxisLimits(RobotTravel(*travels))


def _number(group: Any, field: str) -> float:
    value = group.get(field) if isinstance(group, dict) else None
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if is_number else math.nan
