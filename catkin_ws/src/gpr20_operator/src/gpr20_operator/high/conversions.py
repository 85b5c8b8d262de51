"""ROS messages from and to the records of this package; equal names are taken as they are."""

from __future__ import annotations

import dataclasses
import json

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import VERSIONS_DIFFER
from gpr20_common.high.answers import message_from, record_of
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_doctor.high.node_reports import descriptions
from gpr20_msgs.msg import Annotation as AnnotationMessage
from gpr20_msgs.msg import ControlStatus, RobotConfiguration
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
from gpr20_operator.robot.events import Configured, ControlState, RobotDescribed
from gpr20_survey.plan.annotation import Annotation, Site
from gpr20_survey.plan.robot_description import ANALYZER, robot_config
from gpr20_survey.plan.survey_parameters import (
    DEFAULT_POLARIZATIONS_DEG,
    SurveyParameters,
    SurveySettings,
)
from gpr20_survey.plan.survey_state import SurveyState

LIMITS_UNKNOWN = Message("the limits of the axes are not known").with_fault(VERSIONS_DIFFER)


def parameters_message(parameters: SurveyParameters) -> SurveyParametersMessage:
    return SurveyParametersMessage(**dataclasses.asdict(parameters))


def annotation_message(annotation: Annotation) -> AnnotationMessage:
    return AnnotationMessage(**annotation.fields())


def parameters(message: SurveyParametersMessage) -> SurveyParameters:
    """Convert `survey_parameters`."""
    rotations_deg = tuple(message.polarizations_deg) or DEFAULT_POLARIZATIONS_DEG
    return record_of(SurveyParameters, message, polarizations_deg=rotations_deg)


def control_state(message: ControlStatus) -> ControlState:
    """Convert `control_status`."""
    code, end = SurveyState(message.code), SurveyState(message.end)
    return ControlState(code, message_from(message), message.survey_id, message.simulated, end)


def robot_described(message: RobotConfiguration) -> RobotDescribed:
    """Convert `robot_configuration`."""
    nodes = descriptions(message)
    if not message.known:
        return RobotDescribed(None, message_from(message), nodes)
    try:
        config = robot_config(nodes)
        # Another version of the node may have fields that this one does not know.
        own = nodes["main_control"].configuration
        settings = record_from(SurveySettings, own, "main_control", others=True)
        site = record_from(Site, json.loads(message.site_json), "site", others=True)
        address = str(nodes[ANALYZER].configuration.get("address", ""))
    except (Gpr20Error, ValueError, KeyError, TypeError) as error:
        return RobotDescribed(None, LIMITS_UNKNOWN.with_details(error))
    return RobotDescribed(Configured(config, settings, site, address), nodes=nodes)
