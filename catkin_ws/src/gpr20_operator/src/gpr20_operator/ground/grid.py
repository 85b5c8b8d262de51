"""Places of the ground, where the planned traces of a survey lie, and a finer plan around one."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.plan.form import points_for
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.faults import DAMAGED
from gpr20_survey.folder.log_record import soil_of_survey
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.recorded_plan import TOLERANCE, imported_grid, is_imported, recorded_plan
from gpr20_survey.plan.survey_parameters import (
    RobotTravel,
    SurveyParameters,
    check,
    coordinate_limits_mm,
)
from gpr20_survey.plan.survey_points import grid, on_step

# How wide a single line is drawn, as a part of its length.
LINE_PART = 0.1
# Of a finer survey: width and height, and the smallest distance of its stops.
FINER_SIZE_MM, FINEST_SPACING_MM = 100.0, 1.0
# Coordinates that people can read; finer than a motor step is none.
DECIMALS = 2


@dataclass(frozen=True)
class Area:
    """A rectangle of the ground [mm]."""

    left_mm: float
    right_mm: float
    low_mm: float
    high_mm: float

    @property
    def width_mm(self) -> float:
        return self.right_mm - self.left_mm

    @property
    def height_mm(self) -> float:
        return self.high_mm - self.low_mm

    def grown(self, x_mm: float, y_mm: float) -> Area:
        """Return a rectangle that is larger on each side."""
        return Area(
            self.left_mm - x_mm, self.right_mm + x_mm, self.low_mm - y_mm, self.high_mm + y_mm
        )

    def holds(self, x_mm: float, y_mm: float) -> bool:
        return self.left_mm <= x_mm <= self.right_mm and self.low_mm <= y_mm <= self.high_mm


class Place(NamedTuple):
    """A place above the ground [mm]."""

    x_mm: float
    y_mm: float


class Stop(NamedTuple):
    """One stop of the antennas: its row along Y and its column along X, from 0."""

    row: int
    column: int


Cells = Tuple[np.ndarray, np.ndarray, np.ndarray]
"""Row, column and polarization of many planned traces (whole numbers, each of shape n)."""


@dataclass(eq=False)
class SurveyGrid:
    """The places of one survey: those that were planned, or those of an import.

    Attributes:
        survey_id: UUID.
        simulated: The data show no real ground.
        xs_mm: Columns.
        ys_mm: Rows.
        rotations_deg: Polarizations.
        tolerances: How far a trace may be from its place along x and y [mm], and z [deg].
        plan: What the survey measures, and the limits of the axes; None: it was imported.
        permittivity: Of the ground, as stored with the survey; None: it is not known.
    """

    survey_id: str
    simulated: bool
    xs_mm: np.ndarray
    ys_mm: np.ndarray
    rotations_deg: Tuple[float, ...]
    tolerances: Tuple[float, float, float]
    plan: Optional[Tuple[SurveyParameters, RobotTravel]] = None
    permittivity: Optional[float] = None

    @property
    def shape(self) -> Tuple[int, int]:
        """Rows and columns."""
        return len(self.ys_mm), len(self.xs_mm)

    @property
    def planned(self) -> int:
        """Number of planned traces."""
        return len(self.ys_mm) * len(self.xs_mm) * len(self.rotations_deg)

    @property
    def spacing_mm(self) -> Tuple[float, float]:
        """Distance of two stops along X and Y, which is even.

        That of a single line, which was imported, is a part of its length.
        """
        return _spacing_mm(self.xs_mm, self.ys_mm), _spacing_mm(self.ys_mm, self.xs_mm)

    @property
    def area(self) -> Area:
        """The stops, each with its share of the ground around it."""
        xs_mm, ys_mm, (x_mm, y_mm) = self.xs_mm, self.ys_mm, self.spacing_mm
        stops = Area(*map(float, (xs_mm.min(), xs_mm.max(), ys_mm.min(), ys_mm.max())))
        return stops.grown(x_mm / 2.0, y_mm / 2.0)

    def cells(self, indices: np.ndarray) -> Cells:
        """Return row, column and polarization of places in the plan (whole numbers, shape n).

        The order is that of `survey_points.visits`: columns turn with every row,
        polarizations with every stop.
        """
        columns, polarizations = len(self.xs_mm), len(self.rotations_deg)
        stop, polarization = np.divmod(indices, polarizations)
        row, column = np.divmod(stop, columns)
        polarization = np.where(stop % 2 == 0, polarization, polarizations - 1 - polarization)
        column = np.where(row % 2 == 0, column, columns - 1 - column)
        return row, column, polarization

    def index(self, stop: Stop, polarization: int) -> int:
        """Return the place in the plan of a stop's trace."""
        columns, polarizations = len(self.xs_mm), len(self.rotations_deg)
        row, column = stop
        number = row * columns + (column if row % 2 == 0 else columns - 1 - column)
        polarization = polarization if number % 2 == 0 else polarizations - 1 - polarization
        return number * polarizations + polarization

    @property
    def ascending(self) -> Tuple[slice, slice]:
        """Rows and columns in the order in which Y and X ascend; twice, it is undone."""
        return ascending(self.ys_mm)[0], ascending(self.xs_mm)[0]

    def place_of(self, stop: Stop) -> Place:
        """Return where a stop is."""
        return Place(float(self.xs_mm[stop.column]), float(self.ys_mm[stop.row]))

    def closest_stop(self, x_mm: float, y_mm: float) -> Stop:
        """Return the stop that is closest to a place, wherever that is."""
        column = int(np.argmin(np.abs(self.xs_mm - x_mm)))
        return Stop(int(np.argmin(np.abs(self.ys_mm - y_mm))), column)

    def nearest_stop(self, x_mm: float, y_mm: float) -> Optional[Stop]:
        """Return the stop in whose share of the ground a place lies; None: it lies off the grid."""
        rows, columns = self.shape
        # A line that was imported is near to every place beside it.
        share = self.area.grown(*(math.inf if one == 1 else 1e-9 for one in (columns, rows)))
        return self.closest_stop(x_mm, y_mm) if share.holds(x_mm, y_mm) else None

    def holds(self, cells: Cells, positions: np.ndarray) -> np.ndarray:
        """Return which positions are those of their cells, to half a motor step (bool, shape n).

        Args:
            cells: As `cells` returns them.
            positions: x [mm], y [mm] and z [deg] (shape n x 3).
        """
        row, column, polarization = cells
        rotations_deg = np.array(self.rotations_deg)
        own = np.stack((self.xs_mm[column], self.ys_mm[row], rotations_deg[polarization]), axis=1)
        near: np.ndarray = (np.abs(own - positions) <= self.tolerances).all(axis=1)
        return near


def _spacing_mm(places_mm: np.ndarray, others_mm: np.ndarray) -> float:
    if len(places_mm) > 1:
        return float(abs(places_mm[1] - places_mm[0]))
    return max(LINE_PART * float(np.ptp(others_mm)), 1.0)


def planned_grid(
    survey_id: str, simulated: bool, parameters: SurveyParameters, travel: RobotTravel
) -> SurveyGrid:
    """Return the places of a plan, which lie on motor steps."""
    p = parameters
    return SurveyGrid(
        survey_id,
        simulated,
        np.array(grid(p.x_start_mm, p.x_stop_mm, p.x_points, travel.x)),
        np.array(grid(p.y_start_mm, p.y_stop_mm, p.y_points, travel.y)),
        tuple(on_step(one, travel.z) for one in p.polarizations_deg),
        (travel.x.step / 2, travel.y.step / 2, travel.z.step / 2),
        (parameters, travel),
    )


def grid_from_description(text: str) -> SurveyGrid:
    """Return the grid of a survey from its description.

    Raises:
        SurveyNotReadableError: The text does not describe a survey.
    """
    try:
        values = parse_object(text, "metadata_json", MAX_FILE_BYTES)
        survey_id = values.get("survey_id")
        if not isinstance(survey_id, str):
            raise InvalidValueError(Message("the log has no survey id"), fault=DAMAGED)
        # Data of unknown origin are never shown as those of real ground.
        simulated = values.get("simulated") is not False
        soil = soil_of_survey(values)
        if is_imported(values):
            found = imported_grid(values)
            places = np.array(found.x_mm), np.array(found.y_mm), found.polarization_deg
            own = SurveyGrid(survey_id, simulated, *places, (TOLERANCE, TOLERANCE, TOLERANCE))
        else:
            own = planned_grid(survey_id, simulated, *recorded_plan(values))
    except (InvalidValueError, SurveyRefusedError) as error:
        raise SurveyNotReadableError(
            Message(
                "the survey's plan cannot be read: {reason}", reason=error.message
            ).reporting_only(DAMAGED)
        ) from error
    own.permittivity = None if soil is None else soil.permittivity
    return own


def ascending(places_mm: np.ndarray) -> Tuple[slice, Tuple[float, float]]:
    """Return the order in which places ascend, and the outer edges of their cells."""
    order = slice(None) if places_mm[0] <= places_mm[-1] else slice(None, None, -1)
    half = abs(places_mm[1] - places_mm[0]) / 2.0 if len(places_mm) > 1 else 0.5
    return order, (float(places_mm.min() - half), float(places_mm.max() + half))


@dataclass(frozen=True)
class FinerPlan:
    """What to measure around a place of another survey.

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
    """Return the plan of a survey around a place, with stops half as far apart.

    It is moved where the travel of the robot ends, and larger where three stops need that.

    Raises:
        InvalidValueError: The robot cannot measure it.
    """
    if grid.plan is None:
        raise InvalidValueError(
            Message("an imported survey has no plan that could be measured more finely")
        )
    own, travel = grid.plan
    spacing_mm = max(min(grid.spacing_mm) / 2.0, FINEST_SPACING_MM)
    stops: Dict[str, Any] = {}
    for name, centre_mm, axis in (("x", x_mm, travel.x), ("y", y_mm, travel.y)):
        lowest_mm, highest_mm = coordinate_limits_mm(axis)
        size_mm = min(max(FINER_SIZE_MM, 2.0 * spacing_mm), highest_mm - lowest_mm)
        start_mm = min(max(centre_mm - size_mm / 2.0, lowest_mm), highest_mm - size_mm)
        start_mm = max(round(start_mm, DECIMALS), lowest_mm)
        stop_mm = min(round(start_mm + size_mm, DECIMALS), highest_mm)
        stops[f"{name}_start_mm"], stops[f"{name}_stop_mm"] = start_mm, stop_mm
        stops[f"{name}_points"] = points_for(stop_mm - start_mm, spacing_mm)
    parameters = replace(own, **stops)
    check(parameters, travel)
    return FinerPlan(grid.survey_id, parameters)
