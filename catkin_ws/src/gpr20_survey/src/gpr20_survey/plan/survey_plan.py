"""The order in which a survey visits its points."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from typing import Iterator, List, Sequence, Tuple

from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel


@dataclass(frozen=True)
class SurveyPoint:
    """One trace to be taken: a stop of the antennas and their rotation there.

    Attributes:
        index: Place in the plan, from 0.
        x_mm: Position along X [mm], on a motor step.
        y_mm: Position along Y [mm], on a motor step.
        z_deg: Rotation of the antennas [deg], on a motor step.
    """

    index: int
    x_mm: float
    y_mm: float
    z_deg: float


def survey_points(parameters: SurveyParameters, travel: RobotTravel) -> List[SurveyPoint]:
    """Return the points of a survey in the order of their visit.

    Y is the slow axis and X the fast one, whose direction turns with every row. The
    order of the polarizations turns with every stop, so the antennas rotate once there.
    """
    xs = grid(parameters.x_start_mm, parameters.x_stop_mm, parameters.x_points, travel.x)
    ys = grid(parameters.y_start_mm, parameters.y_stop_mm, parameters.y_points, travel.y)
    rotations = [on_step(rotation, travel.z) for rotation in parameters.polarizations_deg]
    visits = alternating(list(raster(xs, ys)), rotations)
    return [SurveyPoint(index, x, y, z) for index, ((x, y), z) in enumerate(visits)]


def grid(start: float, stop: float, points: int, travel: Travel) -> List[float]:
    """Return evenly spaced coordinates with both ends, each on the nearest motor step."""
    span = stop - start
    return [on_step(start + span * number / (points - 1), travel) for number in range(points)]


def on_step(coordinate: float, travel: Travel) -> float:
    """Return the coordinate of the motor step nearest to a coordinate."""
    step = Decimal(repr(travel.step))
    # Decimal, so that the result is the very float that the axis itself reports.
    return float(round(Decimal(repr(float(coordinate))) / step) * step)


def raster(xs: Sequence[float], ys: Sequence[float]) -> Iterator[Tuple[float, float]]:
    """Yield (x, y) row by row, reversing every second row."""
    for row, y in enumerate(ys):
        for x in xs if row % 2 == 0 else reversed(xs):
            yield x, y


def alternating(
    stops: Sequence[Tuple[float, float]], rotations: Sequence[float]
) -> Iterator[Tuple[Tuple[float, float], float]]:
    """Yield every stop with every rotation, reversing the rotations at every second stop."""
    for number, stop in enumerate(stops):
        for rotation in rotations if number % 2 == 0 else reversed(rotations):
            yield stop, rotation
