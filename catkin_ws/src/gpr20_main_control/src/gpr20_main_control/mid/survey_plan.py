"""What a survey will do: a new one, or one on the disk that continues."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from typing import Any, Dict, List, Optional, Sequence

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.records import record_from
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.robot import ReopenedSurvey
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import planned_durations_s
from gpr20_survey.plan.survey_parameters import SurveyParameters, check
from gpr20_survey.plan.survey_plan import SurveyPoint, survey_points
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.trace.trace import Trace

# What of an axis decides where its coordinates are on the ground.
GRID_PARAMETERS = ("step_size", "min_coord", "max_coord", "type", "homing_backoff")


@dataclass(frozen=True)
class SurveyPlan:
    """What a survey will do.

    Attributes:
        parameters: What it measures.
        config: The robot that measures.
        settings: How it is carried out.
        points: All points in the order of their visit.
        durations_s: How long each takes [s].
        survey_id: UUID; empty before the survey begins.
        reopened: What the storage holds of it; None if it is new.
    """

    parameters: SurveyParameters
    config: RobotConfig
    settings: SurveySettings
    points: Sequence[SurveyPoint]
    durations_s: Sequence[float]
    survey_id: str = ""
    reopened: Optional[ReopenedSurvey] = None

    @property
    def total_points(self) -> int:
        """Number of traces."""
        return len(self.points)

    @property
    def duration_s(self) -> float:
        """How long the whole survey takes [s]."""
        return sum(self.durations_s)

    @property
    def last(self) -> Optional[Trace]:
        """The trace that was stored last, of a survey that is resumed."""
        return None if self.reopened is None else self.reopened.last

    @property
    def stored_indices(self) -> Sequence[int]:
        """Places of the traces that are on the disk, of a survey that is resumed."""
        return () if self.reopened is None else self.reopened.stored_indices

    @property
    def pending(self) -> List[SurveyPoint]:
        """The points that are not on the disk."""
        stored = frozenset(self.stored_indices)
        return [point for point in self.points if point.index not in stored]

    @property
    def pending_durations_s(self) -> List[float]:
        """How long the points that are not on the disk take [s]."""
        return [self.durations_s[point.index] for point in self.pending]


def plan_survey(
    parameters: SurveyParameters, config: RobotConfig, settings: SurveySettings
) -> SurveyPlan:
    """Check the parameters of a survey and plan it.

    Raises:
        SurveyParametersError: Parameters are not allowed; each is named.
    """
    check(parameters, config.travel)
    points = survey_points(parameters, config.travel)
    durations_s = planned_durations_s(points, parameters.frequency_points, config, settings)
    return SurveyPlan(parameters, config, settings, points, durations_s)


def plan_resumption(
    reopened: ReopenedSurvey, config: RobotConfig, settings: SurveySettings
) -> SurveyPlan:
    """Plan the rest of a survey that was cut off or ended early.

    Raises:
        RequestRefusedError: The survey is another robot's, or its metadata are not whole.
        SurveyParametersError: Its parameters are not allowed on this robot.
    """
    plan = plan_survey(_resumable_parameters(reopened, config), config, settings)
    beyond = [index for index in reopened.stored_indices if index >= plan.total_points]
    if beyond:
        raise RequestRefusedError(
            f"the survey in {reopened.folder} holds trace {max(beyond)}, its parameters give only "
            f"{plan.total_points}: its survey.json is not that of its traces"
        )
    return replace(plan, survey_id=reopened.survey_id, reopened=reopened)


def _resumable_parameters(reopened: ReopenedSurvey, config: RobotConfig) -> SurveyParameters:
    try:
        metadata = json.loads(reopened.metadata_json)
        parameters = record_from(SurveyParameters, metadata["parameters"], "parameters")
        simulated, axes = metadata["simulated"], metadata["axes"]
    except (ValueError, KeyError, TypeError, InvalidValueError) as error:
        raise RequestRefusedError(
            f"the survey in {reopened.folder} cannot go on, its survey.json is not whole: {error}"
        ) from error
    if simulated is not config.simulated:
        kinds = {True: "a simulated", False: "the real"}
        raise RequestRefusedError(
            f"the survey in {reopened.folder} was measured by {kinds[bool(simulated)]} robot; it "
            f"cannot go on with {kinds[config.simulated]} one"
        )
    _check_axes(axes, config, reopened.folder)
    return parameters


def _check_axes(recorded: Dict[str, Dict[str, Any]], config: RobotConfig, folder: str) -> None:
    for axis_id, parameters in config.axes.items():
        present = asdict(parameters)
        for name in GRID_PARAMETERS:
            former = recorded.get(axis_id.value, {}).get(name)
            if former != present[name]:
                raise RequestRefusedError(
                    f"the survey in {folder} was measured with {name} {former} of the "
                    f"{axis_id.value} axis, which is {present[name]} now: its points would lie "
                    "elsewhere; launch with the former parameters, or start a new survey"
                )
