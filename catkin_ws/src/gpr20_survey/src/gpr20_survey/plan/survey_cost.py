"""What a survey costs in time and disk space, from the parameters of survey and robot alone."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Dict, List, Sequence

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.axes.ramp import Ramp
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_estimate import (
    MeasuringTimes,
    MoveDuration,
    needed_bytes,
    point_durations_s,
)
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_plan import SurveyPoint, survey_points
from gpr20_survey.plan.survey_settings import SurveySettings

# A survey knows only a few distances, each up to a rounding of its grid.
CACHED_DISTANCES = 4096


@dataclass(frozen=True)
class SurveyCost:
    """What a survey needs.

    Attributes:
        duration_s: From the first move to the last trace [s], homing left out.
        size_bytes: On disk [bytes], rather too large.
    """

    duration_s: float
    size_bytes: int


def axis_move_duration_s(parameters: AxisParameters, distance: float) -> float:
    """Return how long an axis needs for a distance [mm or deg]."""
    ramp = Ramp(parameters.min_step, parameters.max_step, parameters.delta_step)
    return ramp.duration_s(parameters.distance_steps(abs(distance)))


def move_durations(axes: Dict[AxisId, AxisParameters]) -> MoveDuration:
    """Return a function of axis and distance that tells how long a move takes [s]."""

    @functools.lru_cache(maxsize=CACHED_DISTANCES)
    def duration_s(axis_id: AxisId, distance: float) -> float:
        return axis_move_duration_s(axes[axis_id], distance)

    return duration_s


def planned_durations_s(
    points: Sequence[SurveyPoint],
    frequency_points: int,
    facts: RobotConfig,
    settings: SurveySettings,
) -> List[float]:
    """Return how long each point of a survey takes on this robot [s]."""
    times = MeasuringTimes(settings.settle_s, settings.height_s, frequency_points)
    durations_s = point_durations_s(points, move_durations(facts.axes), times)
    return [duration_s / facts.time_scale for duration_s in durations_s]


def survey_cost(
    parameters: SurveyParameters, facts: RobotConfig, settings: SurveySettings
) -> SurveyCost:
    """Return what a survey with these parameters costs on this robot."""
    points = survey_points(parameters, facts.travel)
    duration_s = sum(planned_durations_s(points, parameters.frequency_points, facts, settings))
    return SurveyCost(
        duration_s, needed_bytes(len(points), parameters.frequency_points, duration_s)
    )
