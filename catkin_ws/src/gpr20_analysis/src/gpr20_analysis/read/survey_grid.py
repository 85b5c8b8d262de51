"""The grid of a survey: where which sample belongs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np

from gpr20_analysis.errors import AnalysisError, DamagedSurveyError
from gpr20_common.errors import InvalidValueError
from gpr20_survey.plan.recorded_plan import recorded_plan
from gpr20_survey.plan.survey_plan import SurveyPoint, survey_points
from gpr20_survey.trace.trace import Trace

DECIMALS = 4  # of a millimetre: a hundredth of a motor step
EVEN = 0.1  # of a spacing: how far from even it may be; a motor step at 0.1 mm spacing
MAX_CELLS_PER_TRACE = 16
MAX_FILLING = 4


@dataclass(frozen=True)
class SurveyGrid:
    """Coordinates of a survey, each ascending.

    Attributes:
        polarization_deg: Rotations of the antennas [deg].
        y_mm: Rows [mm].
        x_mm: Columns [mm].
    """

    polarization_deg: Tuple[float, ...]
    y_mm: Tuple[float, ...]
    x_mm: Tuple[float, ...]

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Number of polarizations, rows and columns."""
        return len(self.polarization_deg), len(self.y_mm), len(self.x_mm)

    @property
    def cells(self) -> int:
        """Number of samples of a complete survey."""
        return len(self.polarization_deg) * len(self.y_mm) * len(self.x_mm)

    def places(self, positions: np.ndarray) -> np.ndarray:
        """Return the flat index of the cell of each position.

        Args:
            positions: (samples, 3), rotation [deg], y and x [mm]; each is on the grid.
        """
        flat = np.zeros(len(positions), np.int64)
        for column, axis in enumerate((self.polarization_deg, self.y_mm, self.x_mm)):
            own = np.round(np.array(axis), DECIMALS)
            flat = flat * len(axis) + np.searchsorted(own, np.round(positions[:, column], DECIMALS))
        return flat


def planned_grid(plan: Plan) -> SurveyGrid:
    """Return the grid of a plan."""
    turns, ys, xs = (_ascending(axis) for axis in plan.positions.T.tolist())
    return SurveyGrid(turns, ys, xs)


def grid_of(positions: np.ndarray, notes: List[str]) -> SurveyGrid:
    """Return the grid on which positions lie, when no plan tells it.

    A row or column without any sample, between others, is put in where the spacing shows it.

    Args:
        positions: (samples, 3), rotation [deg], y and x [mm].
        notes: Takes what was concluded.

    Raises:
        DamagedSurveyError: The positions are on no grid.
    """
    turns, ys, xs = (_ascending(positions[:, column].tolist()) for column in range(3))
    grid = SurveyGrid(turns, _filled(ys, "y", notes), _filled(xs, "x", notes))
    if grid.cells > MAX_CELLS_PER_TRACE * len(positions):
        raise DamagedSurveyError(
            f"{len(positions)} samples lie at {len(grid.x_mm)} different x and {len(grid.y_mm)} "
            "different y: that is no grid; name the folder of the survey, whose survey.json "
            "tells the grid"
        )
    return grid


def _ascending(values: Sequence[float]) -> Tuple[float, ...]:
    # Rounding decides what is one coordinate; the coordinate itself stays as it was read.
    found: Dict[float, float] = {}
    for value in values:
        found.setdefault(round(value, DECIMALS) + 0.0, value)
    return tuple(found[key] for key in sorted(found))


def _filled(values: Tuple[float, ...], name: str, notes: List[str]) -> Tuple[float, ...]:
    if len(values) < 3:
        return values
    spacings = np.diff(values)
    steps = spacings / spacings.min()
    whole = np.round(steps)
    if np.abs(steps - whole).max() > EVEN or whole.sum() > MAX_FILLING * len(values):
        notes.append(
            f"the spacing of {name} is not even: {spacings.min():g} to {spacings.max():g} mm"
        )
        return values
    if whole.max() == 1.0:
        return values
    filled: List[float] = [values[0]]
    for lower, upper, parts in zip(values, values[1:], whole.astype(int)):
        filled += [lower + (upper - lower) * part / parts for part in range(1, parts)] + [upper]
    notes.append(
        f"{len(filled) - len(values)} places in {name} without any sample were put in, as the "
        "spacing shows them"
    )
    return tuple(filled)


class Plan:
    """The samples that a survey was to take, worked out from its survey.json."""

    def __init__(self, description: Dict[str, Any]) -> None:
        """Work out the plan.

        Raises:
            AnalysisError: Parameters or axes are missing or not allowed.
        """
        try:
            self._parameters, self._travel = recorded_plan(description)
        except InvalidValueError as error:
            raise AnalysisError(
                f"what was planned cannot be told, survey.json is not whole: {error}"
            ) from error
        self.points: List[SurveyPoint] = survey_points(self._parameters, self._travel)
        self.positions = np.array([(one.z_deg, one.y_mm, one.x_mm) for one in self.points])
        """Rotation [deg], y and x [mm] of each, (samples, 3)."""

    def misplaced(self, trace: Trace) -> List[str]:
        """Return how a trace is not what was planned for its index."""
        if trace.index >= len(self.points):
            return [f"trace {trace.index} was not planned, the plan has {len(self.points)}"]
        point = self.points[trace.index]
        found = []
        for name, own, planned, travel in (
            ("x", trace.x_coord_mm, point.x_mm, self._travel.x),
            ("y", trace.y_coord_mm, point.y_mm, self._travel.y),
            ("z", trace.z_coord_deg, point.z_deg, self._travel.z),
        ):
            # Both are whole motor steps: half a step apart is another place.
            if abs(own - planned) > travel.step / 2:
                found.append(
                    f"trace {trace.index} was taken at {name} {own:g}, planned was {planned:g}"
                )
        if len(trace.frequency_hz) != self._parameters.frequency_points:
            found.append(
                f"trace {trace.index} has {len(trace.frequency_hz)} points, planned were "
                f"{self._parameters.frequency_points}"
            )
        return found
