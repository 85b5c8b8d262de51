"""ROS messages from and to the records of this package."""

from __future__ import annotations

import dataclasses
import itertools
import json
from typing import Any, Dict, Mapping, Sequence

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import VERSIONS_DIFFER
from gpr20_common.high.answers import fault_of, message_from, received, record_of
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_doctor.high.node_reports import descriptions
from gpr20_msgs.msg import Annotation as AnnotationMessage
from gpr20_msgs.msg import (
    ControlStatus,
    Fault,
    RobotConfiguration,
    SurveyCoverage,
    SurveyData,
)
from gpr20_msgs.msg import Replay as ReplayMessage
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
from gpr20_operator.ground.additions import MarkersStored
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.traces import SurveysListed, TracesRead
from gpr20_operator.robot.events import (
    Configured,
    ControlState,
    Progress,
    Replay,
    ReplayPhase,
    RobotDescribed,
)
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.annotation import Annotation, Site
from gpr20_survey.plan.markers import present_markers
from gpr20_survey.plan.robot_description import ANALYZER, robot_config
from gpr20_survey.plan.survey_parameters import (
    DEFAULT_POLARIZATIONS_DEG,
    SurveyParameters,
    SurveySettings,
)
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_survey.trace.trace_block import block_from

LIMITS_UNKNOWN = Message("the limits of the axes are not known").with_fault(VERSIONS_DIFFER)


def replay(message: ReplayMessage) -> Replay:
    """Convert `replay`."""
    return Replay(
        survey_id=message.survey_id,
        started=message.started,
        folder=message.folder,
        phase=ReplayPhase(message.state),
        rate=message.rate,
    )


def parameters_message(parameters: SurveyParameters) -> SurveyParametersMessage:
    return SurveyParametersMessage(**dataclasses.asdict(parameters))


def annotation_message(annotation: Annotation) -> AnnotationMessage:
    return AnnotationMessage(**annotation.fields())


def parameters(message: SurveyParametersMessage) -> SurveyParameters:
    """Convert `survey_parameters`."""
    values = {name: getattr(message, name) for name in message.__slots__}
    values["polarizations_deg"] = tuple(message.polarizations_deg) or DEFAULT_POLARIZATIONS_DEG
    return SurveyParameters(**values)


def control_state(message: ControlStatus) -> ControlState:
    """Convert `control_status`."""
    code, end = SurveyState(message.code), SurveyState(message.end)
    return ControlState(code, message_from(message), message.survey_id, message.simulated, end=end)


def progress(message: SurveyData) -> Progress:
    """Convert `control_survey_data`."""
    return Progress(
        survey_id=message.survey_id,
        completion_percent=message.completion_percent,
        total_points=message.total_points,
        visited_points=message.visited_points,
        remaining_s=message.remaining_time.to_sec(),
    )


def coverage_runs(message: SurveyCoverage) -> CoverageRuns:
    """Convert `survey_coverage`."""
    verdict = received(message.verdict, message.verdict_fault)
    return CoverageRuns(
        survey_id=message.survey_id,
        planned=message.planned,
        starts=tuple(message.run_starts),
        states=tuple(bytearray(message.run_states)),
        failures=_reasons(message.failures, message.failure_faults),
        verdict=verdict if message.verdict else None,
    )


def traces_read(first_index: int, response: Any) -> TracesRead:
    """Convert the answer of `read_traces`.

    Raises:
        TraceRefusedError: A trace is not as it should be.
    """
    unreadable = _reasons(response.unreadable, response.unreadable_faults)
    return TracesRead(first_index, block_from(response), unreadable)


def surveys_listed(before: str, response: Any) -> SurveysListed:
    """Convert the answer of `list_surveys`."""
    surveys = tuple(record_of(SurveySummary, one) for one in response.surveys)
    return SurveysListed(before, surveys, response.more)


def fact_fields(survey: str, kind: Kind, values: Mapping[str, Any]) -> Dict[str, Any]:
    """Return what `add_fact` is sent of a fact."""
    values_json = json.dumps(values, allow_nan=False)
    return {"survey": survey, "kind": kind.value, "values_json": values_json}


def markers_stored(response: Any) -> MarkersStored:
    """Convert the answer of `add_fact` to a fact of markers.

    Raises:
        InvalidValueError: A marker is not as the storage writes it.
    """
    description = {"markers": json.loads(response.markers_json)}
    return MarkersStored(response.survey_id, present_markers(description))


def _reasons(texts: Sequence[str], faults_of: Sequence[Fault]) -> Dict[int, Message]:
    """Return the reasons of traces by their index, from lines "index: reason"."""
    found = {}
    for line, fault in itertools.zip_longest(texts, faults_of[: len(texts)]):
        index, _separator, text = line.partition(": ")
        if index.isdigit():
            found[int(index)] = received(text, fault or fault_of(None))
    return found


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
