"""The points of a survey, in the order in which it visits them."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import List, Sequence

from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel


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
