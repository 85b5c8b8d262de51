"""Where the planned traces of a survey lie: places in the plan, rows, columns and polarizations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.records import Place, ascending
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.faults import DAMAGED
from gpr20_survey.folder.soil_note import soil_of_survey
from gpr20_survey.folder.survey_metadata import MAX_FILE_BYTES, parse_object
from gpr20_survey.plan.imported import TOLERANCE, imported_grid, is_imported
from gpr20_survey.plan.recorded_plan import recorded_plan
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters
from gpr20_survey.plan.survey_points import grid, on_step


@dataclass(frozen=True)
class Stop:
    """One stop of the antennas: its row along Y and its column along X, from 0."""

    row: int
    column: int


@dataclass(frozen=True)
class Cell:
    """One planned trace: a stop and the number of its polarization, from 0."""

    stop: Stop
    polarization: int


Cells = Tuple[np.ndarray, np.ndarray, np.ndarray]
"""Row, column and polarization of many cells (whole numbers, each of shape n)."""


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

    def cell(self, index: int) -> Cell:
        """Return where a place in the plan is.

        Raises:
            SurveyNotReadableError: The plan has no such place.
        """
        if not 0 <= index < self.planned:
            raise SurveyNotReadableError(
                Message(
                    "trace {index} was not planned; the plan has {planned} traces",
                    index=index,
                    planned=self.planned,
                )
            )
        row, column, polarization = self.cells(np.array([index]))
        return Cell(Stop(int(row[0]), int(column[0])), int(polarization[0]))

    def index(self, cell: Cell) -> int:
        """Return the place in the plan of a cell."""
        columns, polarizations = len(self.xs_mm), len(self.rotations_deg)
        row, column = cell.stop.row, cell.stop.column
        stop = row * columns + (column if row % 2 == 0 else columns - 1 - column)
        polarization = cell.polarization if stop % 2 == 0 else polarizations - 1 - cell.polarization
        return stop * polarizations + polarization

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
        stop = self.closest_stop(x_mm, y_mm)
        own = self.place_of(stop)
        for places_mm, away_mm in ((self.xs_mm, own.x_mm - x_mm), (self.ys_mm, own.y_mm - y_mm)):
            # A line that was imported is near to every place beside it.
            spacing_mm = abs(places_mm[1] - places_mm[0]) if len(places_mm) > 1 else math.inf
            # Written so that NaN, which fails every comparison, is off the grid too.
            if not abs(away_mm) <= spacing_mm / 2 + 1e-9:
                return None
        return stop

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
        permittivity = None if soil is None else soil.permittivity
        if not is_imported(values):
            own = planned_grid(survey_id, simulated, *recorded_plan(values))
            own.permittivity = permittivity
            return own
        found = imported_grid(values)
    except (InvalidValueError, SurveyRefusedError) as error:
        raise SurveyNotReadableError(
            Message(
                "the survey's plan cannot be read: {reason}", reason=error.message
            ).reporting_only(DAMAGED)
        ) from error
    places = np.array(found.x_mm), np.array(found.y_mm), found.polarization_deg
    tolerances = (TOLERANCE, TOLERANCE, TOLERANCE)
    return SurveyGrid(survey_id, simulated, *places, tolerances, permittivity=permittivity)
