"""A small survey around a place of another one, with its stops half as far apart."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.ground.grid import Area, SurveyGrid
from gpr20_survey.plan.survey_parameters import (
    MIN_GRID_POINTS,
    SurveyParameters,
    Travel,
    check,
    coordinate_limits_mm,
)

# Width and height; the plan can be changed before it starts.
SIZE_MM = 100.0
SMALLEST_SPACING_MM = 1.0
# Coordinates that people can read; finer than a motor step is none.
DECIMALS = 2


@dataclass(frozen=True)
class FinerPlan:
    """What to measure around a place.

    Attributes:
        refines: Id of the survey in which the place was found.
        parameters: Those of that survey, but for area and points.
    """

    refines: str
    parameters: SurveyParameters

    @property
    def area(self) -> Area:
        """From the first stop to the last one."""
        p = self.parameters
        return Area(p.x_start_mm, p.x_stop_mm, p.y_start_mm, p.y_stop_mm)

    def refined_by(self, parameters: SurveyParameters) -> str:
        """Return the id of the survey that other parameters refine; empty if they do not.

        Spacing and sweep may have been changed meanwhile, the area may have been made smaller.
        """
        p, area = parameters, self.area.grown(1e-6, 1e-6)
        first, last = area.holds(p.x_start_mm, p.y_start_mm), area.holds(p.x_stop_mm, p.y_stop_mm)
        return self.refines if first and last else ""


def plan_finer(grid: SurveyGrid, x_mm: float, y_mm: float) -> FinerPlan:
    """Return the plan of a survey around a place, within the travel of the robot.

    It has at least three stops along X and Y: it is larger than usual, or moved, where it must be.

    Raises:
        InvalidValueError: The robot cannot measure it.
    """
    if grid.plan is None:
        raise InvalidValueError(
            Message("an imported survey has no plan that could be measured more finely")
        )
    own, travel = grid.plan
    spacing_mm = max(round(min(grid.spacing_mm) / 2.0, DECIMALS), SMALLEST_SPACING_MM)
    x_start_mm, x_stop_mm, x_points = _stops(x_mm, spacing_mm, travel.x)
    y_start_mm, y_stop_mm, y_points = _stops(y_mm, spacing_mm, travel.y)
    parameters = replace(
        own,
        x_start_mm=x_start_mm,
        x_stop_mm=x_stop_mm,
        x_points=x_points,
        y_start_mm=y_start_mm,
        y_stop_mm=y_stop_mm,
        y_points=y_points,
    )
    check(parameters, travel)
    return FinerPlan(grid.survey_id, parameters)


def _stops(centre_mm: float, spacing_mm: float, travel: Travel) -> Tuple[float, float, int]:
    """Return first and last stop of an axis [mm], and their number."""
    lowest_mm, highest_mm = coordinate_limits_mm(travel)
    most_mm = highest_mm - lowest_mm
    gaps = max(math.floor(min(SIZE_MM, most_mm) / spacing_mm + 1e-6), MIN_GRID_POINTS - 1)
    span_mm = min(gaps * spacing_mm, most_mm)
    start_mm = min(max(centre_mm - span_mm / 2.0, lowest_mm), highest_mm - span_mm)
    stop_mm = min(round(start_mm + span_mm, DECIMALS), highest_mm)
    return max(round(start_mm, DECIMALS), lowest_mm), stop_mm, gaps + 1
