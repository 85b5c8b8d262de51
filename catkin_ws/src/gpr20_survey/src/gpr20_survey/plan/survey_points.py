"""The points of a survey in the order of their visit, and what it costs: time and space."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from decimal import Decimal
from itertools import takewhile
from typing import Callable, List, Sequence, Tuple

from gpr20_survey.axes import AxisId, AxisParameters, Ramp
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import (
    RobotTravel,
    SurveyParameters,
    SurveySettings,
    Travel,
)
from gpr20_survey.trace.sweep import SweepSettings, sweep_duration_s


@dataclass(frozen=True)
class SurveyPoint:
    """One trace to be taken, by its place in the plan; stop and rotation are on motor steps."""

    index: int
    x_mm: float
    y_mm: float
    z_deg: float


def survey_points(parameters: SurveyParameters, travel: RobotTravel) -> List[SurveyPoint]:
    xs = grid(parameters.x_start_mm, parameters.x_stop_mm, parameters.x_points, travel.x)
    ys = grid(parameters.y_start_mm, parameters.y_stop_mm, parameters.y_points, travel.y)
    return visits(xs, ys, [on_step(one, travel.z) for one in parameters.polarizations_deg])


def visits(
    xs_mm: Sequence[float], ys_mm: Sequence[float], rotations_deg: Sequence[float]
) -> List[SurveyPoint]:
    """Return every stop with every rotation.

    Y is the slow axis and X the fast one, whose direction turns with every row. The order of the
    rotations turns with every stop, so the antennas rotate once there.
    """
    stops = [(x, y) for row, y in enumerate(ys_mm) for x in (xs_mm, xs_mm[::-1])[row % 2]]
    turns = (rotations_deg, rotations_deg[::-1])
    places = [(*stop, z) for number, stop in enumerate(stops) for z in turns[number % 2]]
    return [SurveyPoint(index, *place) for index, place in enumerate(places)]


def grid(start: float, stop: float, points: int, travel: Travel) -> List[float]:
    """Return evenly spaced coordinates with both ends, each on the nearest motor step."""
    span = stop - start
    return [on_step(start + span * number / (points - 1), travel) for number in range(points)]


def on_step(coordinate: float, travel: Travel) -> float:
    step = Decimal(repr(travel.step))
    # Decimal, so that the result is the very float that the axis itself reports.
    return float(round(Decimal(repr(float(coordinate))) / step) * step)


# A JSON file holds three numbers of up to 24 characters per frequency, the recording and the bag
# three doubles each; they hardly compress noise.
BYTES_PER_FREQUENCY = 3 * 24 + 2 * 3 * 8
BYTES_PER_TRACE = 4096
# Positions at up to 150 messages per second and everything else, in the recording and the bag.
RECORDED_BYTES_PER_S = 40_000

# At each return to the first stop it is swept this many times in a row: that shows the noise.
VISIT_SWEEPS = 2

# A survey knows only a few distances, each up to a rounding of its grid.
CACHED_DISTANCES = 4096

MoveDuration = Callable[[AxisId, float], float]


@dataclass(frozen=True)
class SurveyCost:
    """The time of a survey without homing [s], and a generous estimate of its size on disk."""

    duration_s: float
    size_bytes: int


def survey_cost(
    parameters: SurveyParameters, config: RobotConfig, settings: SurveySettings
) -> SurveyCost:
    """Return what a survey with these parameters costs on this robot."""
    points = survey_points(parameters, config.travel)
    times = planned_times(points, parameters.sweep_settings, config, settings)
    duration_s = sum(times.durations_s)
    size = needed_bytes(len(points), parameters.frequency_points, duration_s)
    return SurveyCost(duration_s, size)


@dataclass(frozen=True)
class PlannedTimes:
    """When a survey does what.

    Attributes:
        durations_s: Duration of each point [s], with the visit of the reference before it; one more
            for the visit at the end, if any.
        visits: Indices of the points before which the reference is visited, ascending; the number
            of points for the visit at the end.
    """

    durations_s: Sequence[float]
    visits: Tuple[int, ...]


def planned_times(
    points: Sequence[SurveyPoint],
    sweep: SweepSettings,
    config: RobotConfig,
    settings: SurveySettings,
) -> PlannedTimes:
    """Return how long each point of a survey takes on this robot, and when it visits its reference.

    The reference is the first stop, at each of its rotations.
    """
    sweep_s = sweep_duration_s(sweep)
    # The height is measured while vibrations settle.
    point_s = max(settings.settle_s, settings.height_s) + sweep_s
    visit_s = point_s + (VISIT_SWEEPS - 1) * sweep_s

    @functools.lru_cache(maxsize=CACHED_DISTANCES)
    def move_s(axis_id: AxisId, distance: float) -> float:
        return axis_move_duration_s(config.axes[axis_id], distance)

    # The move to the first point begins at the zero of the axes.
    path = [SurveyPoint(-1, 0.0, 0.0, 0.0), *points]
    durations_s = [one_s + point_s for one_s in _moves_s(path, move_s)]
    reference = first_stop(points)
    visits = _planned_visits(durations_s, len(reference), settings.reference_interval_s)
    durations_s += [0.0] * bool(visits)
    for index in visits:
        path = [points[index - 1], *reference, *points[index : index + 1]]
        direct_s = sum(_moves_s(points[index - 1 : index + 1], move_s))
        durations_s[index] += sum(_moves_s(path, move_s)) - direct_s + len(reference) * visit_s
    return PlannedTimes([one_s / config.time_scale for one_s in durations_s], visits)


def first_stop(points: Sequence[SurveyPoint]) -> List[SurveyPoint]:
    """Return the points of the first stop: one for each rotation."""
    x_mm, y_mm = points[0].x_mm, points[0].y_mm
    return list(takewhile(lambda one: (one.x_mm, one.y_mm) == (x_mm, y_mm), points))


def _planned_visits(
    durations_s: Sequence[float], rotations: int, interval_s: float
) -> Tuple[int, ...]:
    """Return before which points a survey visits its reference: at new stops, and at its end.

    A survey that is shorter than the interval never does, nor one whose interval is 0.
    """
    if not interval_s or sum(durations_s) < interval_s:
        return ()
    visits, since_s = [], 0.0
    for index, duration_s in enumerate(durations_s):
        if since_s >= interval_s and index % rotations == 0:
            visits.append(index)
            since_s = 0.0
        since_s += duration_s
    return (*visits, len(durations_s))


def _moves_s(path: Sequence[SurveyPoint], move_s: MoveDuration) -> List[float]:
    return [
        max(
            move_s(AxisId.X, after.x_mm - before.x_mm),
            move_s(AxisId.Y, after.y_mm - before.y_mm),
            move_s(AxisId.Z, after.z_deg - before.z_deg),
        )
        for before, after in zip(path, path[1:])
    ]


def needed_bytes(traces: int, frequency_points: int, duration_s: float) -> int:
    """Return a generous estimate of the size of a survey on disk [bytes]."""
    per_trace = BYTES_PER_FREQUENCY * frequency_points + BYTES_PER_TRACE
    return traces * per_trace + int(duration_s * RECORDED_BYTES_PER_S)


def axis_move_duration_s(parameters: AxisParameters, distance: float) -> float:
    """Return how long an axis needs for a distance [mm or deg]."""
    ramp = Ramp(parameters.min_step, parameters.max_step, parameters.delta_step)
    return ramp.duration_s(parameters.distance_steps(abs(distance)))
