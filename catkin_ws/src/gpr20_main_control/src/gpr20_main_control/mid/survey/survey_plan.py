"""The plan of a survey: of a new one, or of one on the disk that is resumed."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_main_control.errors import OTHER_ROBOT, RECORD_DAMAGED, RequestRefusedError
from gpr20_survey.axes import AxisParameters
from gpr20_survey.faults import NO_PLAN
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.recorded_plan import recorded_settings
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveyParameters, SurveySettings, check
from gpr20_survey.plan.survey_points import SurveyPoint, planned_times, survey_points
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace.sweep import AnalyzerSettings, SweepSettings
from gpr20_survey.trace.trace import Trace

# What is stored of a survey before it begins.
NEW = ReopenedSurvey("", "", "{}", "", (), ())
# Keys of the description.
PLAN_ID, PLAN_SET_BY = "plan_id", "plan_set_by"
# Parameters of an axis that decide where its coordinates are on the ground.
GRID_PARAMETERS = (
    "step_size",
    "min_coord",
    "max_coord",
    "type",
    "homing_backoff",
    "invert_direction",
)


@dataclass(frozen=True)
class SurveyPlan:
    """The plan of a survey.

    Attributes:
        points: In the order of their visit.
        durations_s: Duration of each point [s], with a visit of the reference before it, if any;
            one more for the visit at the end, if any.
        set_by: Node that set the parameters; empty if it is not known.
        survey_id: UUID; empty before the survey begins.
        reopened: What is stored of it, if it is resumed.
        refines: Id of the survey that it measures more finely; empty: none.
        permittivity: Relative permittivity of the ground; None: not known.
        visits: Indices of the points before which it visits its reference, the first stop, to see
            the drift; the number of points for the visit at the end.
    """

    parameters: SurveyParameters
    config: RobotConfig
    settings: SurveySettings
    points: Sequence[SurveyPoint]
    durations_s: Sequence[float]
    set_by: str = ""
    survey_id: str = ""
    reopened: ReopenedSurvey = NEW
    annotation: Annotation = EMPTY
    refines: str = ""
    permittivity: Optional[float] = None
    visits: Sequence[int] = ()

    @property
    def sweep_settings(self) -> SweepSettings:
        """What each sweep covers, measured as the survey was measured so far."""
        wanted = self.parameters.sweep_settings
        recorded = recorded_settings(self.metadata)
        return replace(wanted, analyzer=recorded) if recorded != AnalyzerSettings() else wanted

    @property
    def metadata(self) -> Mapping[str, Any]:
        """What the log says of a survey that is resumed; nothing otherwise."""
        return json.loads(self.reopened.metadata_json)

    @property
    def total_points(self) -> int:
        return len(self.points)

    @property
    def duration_s(self) -> float:
        return sum(self.durations_s)

    def prove(self, plan_id: str) -> None:
        """Refuse another plan than that of an id; an empty one means any plan."""
        present = self.parameters.plan_id
        if plan_id not in ("", present):
            raise RequestRefusedError(
                Message(
                    "START is for plan {requested}, but plan {present} is set, by {set_by}; "
                    "set the plan again, then start",
                    requested=repr(plan_id[:64]),
                    set_by=self.set_by or "-",
                    present=present,
                ),
                fault=NO_PLAN,
            )

    @property
    def last(self) -> Optional[Trace]:
        """The trace stored last, of a survey that is resumed; None otherwise."""
        return self.reopened.recent[-1] if self.reopened.recent else None

    @property
    def pending(self) -> List[SurveyPoint]:
        """The points that are not on the disk yet."""
        stored = frozenset(self.reopened.stored_indices)
        return [point for point in self.points if point.index not in stored]

    @property
    def pending_durations_s(self) -> List[float]:
        """Durations of the points that are not on the disk yet, and of the end [s]."""
        at_end = self.durations_s[self.total_points :]
        return [*(self.durations_s[point.index] for point in self.pending), *at_end]


def plan_survey(
    parameters: SurveyParameters, config: RobotConfig, settings: SurveySettings
) -> SurveyPlan:
    """Plan a survey, or raise an InvalidValueError that names each wrong parameter."""
    check(parameters, config.travel)
    points = survey_points(parameters, config.travel)
    times = planned_times(points, parameters.sweep_settings, config, settings)
    return SurveyPlan(parameters, config, settings, points, times.durations_s, visits=times.visits)


def plan_resumption(
    reopened: ReopenedSurvey, config: RobotConfig, settings: SurveySettings
) -> SurveyPlan:
    """Plan the rest of a survey that was cut off or ended early, unless it is not of this robot."""
    try:
        metadata = json.loads(reopened.metadata_json)
        parameters = record_from(SurveyParameters, metadata["parameters"], "parameters")
        recorded = {
            one: record_from(AxisParameters, metadata["axes"][one.value], f"axes/{one.value}", True)
            for one in config.axes
        }
        simulated = metadata["simulated"]
    except (ValueError, KeyError, TypeError) as error:
        raise _damaged(reopened, f"{type(error).__name__}: {error}") from error
    compared: Dict[str, Tuple[Any, Any]] = {"simulation": (simulated, config.simulated)}
    for axis_id, axis in config.axes.items():
        for name in GRID_PARAMETERS:
            values = getattr(recorded[axis_id], name), getattr(axis, name)
            compared[f"{axis_id.value} {name}"] = values
    for name, (former, present) in compared.items():
        if former != present:
            raise RequestRefusedError(
                Message(
                    "the survey in {folder} was measured by a robot whose {name} was {former}, "
                    "which is {present} now: they do not belong together; launch it as it was, "
                    "or start a new survey",
                    folder=reopened.path,
                    name=name,
                    former=str(former),
                    present=str(present),
                ),
                fault=OTHER_ROBOT,
            )
    plan = plan_survey(parameters, config, settings)
    if max(reopened.stored_indices, default=0) >= plan.total_points:
        raise _damaged(reopened, f"{max(reopened.stored_indices)} of {plan.total_points}")
    set_by = str(metadata.get(PLAN_SET_BY, ""))
    return replace(plan, set_by=set_by, survey_id=reopened.survey_id, reopened=reopened)


def _damaged(reopened: ReopenedSurvey, details: str) -> RequestRefusedError:
    return RequestRefusedError(
        Message(
            "the survey in {folder} cannot be resumed: the plan in its log is incomplete, or does "
            "not belong to its traces; plan a new survey",
            folder=reopened.path,
            details=details,
        ),
        fault=RECORD_DAMAGED,
    )
