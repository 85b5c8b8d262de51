"""Limits and figures of the robot, from what its nodes say about themselves."""

from __future__ import annotations

import dataclasses
import json
from typing import Any, Mapping

from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.records import record_from
from gpr20_common.sent_message import message_from
from gpr20_doctor.high.node_reports import descriptions
from gpr20_msgs.msg import RobotConfiguration
from gpr20_operator import faults
from gpr20_operator.robot.events import AxisLimits, RobotDefaults, RobotFigures
from gpr20_survey.plan.robot_description import ANALYZER, NodeDescription, robot_config
from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_settings import SurveySettings

CONTROL = "main_control"
UNKNOWN = Message("the limits of the axes are not known").with_fault(faults.LIMITS_UNKNOWN)


def axis_limits(message: RobotConfiguration) -> AxisLimits:
    """Return the limits of the three axes and the figures of the robot, or why they are unknown."""
    nodes = descriptions(message)
    if not message.known:
        return AxisLimits(None, message_from(message), nodes=nodes)
    try:
        config = robot_config(nodes)
        settings = _record(SurveySettings, nodes[CONTROL].configuration)
        defaults = _defaults(nodes, message.site_json)
    except (Gpr20Error, ValueError, KeyError, TypeError) as error:
        reason = Message("the limits of the axes are not known", details=error)
        return AxisLimits(None, reason.with_fault(faults.LIMITS_UNKNOWN))
    figures = RobotFigures(config, settings)
    return AxisLimits(config.travel, figures=figures, defaults=defaults, nodes=nodes)


def _defaults(nodes: Mapping[str, NodeDescription], site_json: str) -> RobotDefaults:
    site = _record(Site, json.loads(site_json))
    address = nodes[ANALYZER].configuration.get("address", "")
    return RobotDefaults(str(address), site)


def _record(record_class: Any, values: Any) -> Any:
    # Another version of the node may have fields that this one does not know.
    if not isinstance(values, Mapping):
        raise InvalidValueError(UNKNOWN)
    names = {field.name for field in dataclasses.fields(record_class)}
    known = {name: value for name, value in values.items() if name in names}
    return record_from(record_class, known, record_class.__name__)
