"""Limits and figures of the robot, from the parameters of its nodes."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Dict, List
from xmlrpc.client import Error as XmlRpcError

import rospy

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_common.mid.checks import positive_number
from gpr20_common.mid.records import record_from
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_user_interface.mid.events import AxisLimits, RobotFigures

FIELDS = ("min_coord", "max_coord", "step_size")


def read_axis_limits() -> AxisLimits:
    """Read the limits of the three axes and the figures of the robot, or why they are unknown."""
    try:
        groups = {axis_id: _group(f"{axis_id.value}_axis/axis_driver") for axis_id in AxisId}
        control = _group("main_control")
        time_scale = rospy.get_param("time_scale", 1.0)
        simulated = rospy.get_param("simulated", False)
    except (rospy.ROSException, XmlRpcError, OSError) as error:
        reason = Message("the ROS master does not answer", details=error)
        return AxisLimits(None, reason, master_alive=False)
    travels: List[Travel] = []
    for axis_id, group in groups.items():
        values = [_number(group, field) for field in FIELDS]
        if not all(math.isfinite(value) for value in values):
            name = rospy.resolve_name(f"{axis_id.value}_axis/axis_driver")
            details = f"{name} has no parameters {', '.join(FIELDS)}"
            reason = Message("the limits of the axes are not known", details=details)
            return AxisLimits(None, reason)
        travels.append(Travel(*values))
    try:
        axes = {axis_id: _record(AxisParameters, group) for axis_id, group in groups.items()}
        config = RobotConfig(axes, bool(simulated), positive_number("time_scale", time_scale))
        figures = RobotFigures(config, _record(SurveySettings, control))
    except Gpr20Error as error:
        return AxisLimits(RobotTravel(*travels), error.message)
    except TypeError as error:
        reason = Message("the parameters of the robot are incomplete", details=error)
        return AxisLimits(RobotTravel(*travels), reason)
    return AxisLimits(RobotTravel(*travels), figures=figures)


def _group(name: str) -> Dict[str, Any]:
    group = rospy.get_param(rospy.resolve_name(name), {})
    return group if isinstance(group, dict) else {}


def _record(record_class: Any, group: Dict[str, Any]) -> Any:
    # The groups belong to other nodes, which refuse what they do not know.
    names = {field.name for field in dataclasses.fields(record_class)}
    known = {name: value for name, value in group.items() if name in names}
    return record_from(record_class, known, record_class.__name__)


def _number(group: Dict[str, Any], field: str) -> float:
    value = group.get(field)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    return math.nan
