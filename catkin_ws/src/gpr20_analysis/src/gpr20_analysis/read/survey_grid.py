"""The grid of a survey: the position of each sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Sequence, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import DamagedSurveyError
from gpr20_common.message import Message
from gpr20_survey.faults import DAMAGED
from gpr20_survey.plan.imported import ImportedGrid
from gpr20_survey.plan.recorded_plan import PlanFit

DECIMALS = 4  # of a millimetre: a hundredth of a motor step
EVEN = 0.1  # tolerance of even spacing, as a share of it; a motor step at 0.1 mm spacing
MAX_CELLS_PER_TRACE = 16
MAX_FILLING = 4


@dataclass(frozen=True)
class SurveyGrid(ImportedGrid):
    """Coordinates of a survey, each ascending."""

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Number of polarizations, rows and columns."""
        return len(self.polarization_deg), len(self.y_mm), len(self.x_mm)

    @property
    def cells(self) -> int:
        """Number of samples of a complete survey."""
        return len(self.polarization_deg) * len(self.y_mm) * len(self.x_mm)

    def places(self, positions: np.ndarray) -> np.ndarray:
        """Return the flat index of the grid cell of each position.

        Args:
            positions: (samples, 3), rotation [deg], y and x [mm]; each is on the grid.
        """
        flat = np.zeros(len(positions), np.int64)
        for column, axis in enumerate((self.polarization_deg, self.y_mm, self.x_mm)):
            own = np.round(np.array(axis), DECIMALS)
            flat = flat * len(axis) + np.searchsorted(own, np.round(positions[:, column], DECIMALS))
        return flat


def planned_positions(plan: PlanFit) -> np.ndarray:
    """Return rotation [deg], y and x [mm] of each planned sample, (samples, 3)."""
    return np.array([(one.z_deg, one.y_mm, one.x_mm) for one in plan.points])


def unknown_plan(reason: Message) -> Message:
    """Return the fault of a description whose plan is missing or invalid."""
    return Message("the plan is unknown: {reason}", reason=reason).reporting_only(DAMAGED)


def exact_grid(positions: np.ndarray) -> SurveyGrid:
    """Return the grid of positions that are those of all samples."""
    return SurveyGrid(*(_ascending(axis) for axis in positions.T.tolist()))


def grid_of(positions: np.ndarray, notes: List[Message]) -> SurveyGrid:
    """Return the grid of positions without a plan.

    Rows and columns without any sample are inserted where the spacing of the others shows a gap.

    Args:
        positions: (samples, 3), rotation [deg], y and x [mm].
        notes: Conclusions are added here.

    Raises:
        DamagedSurveyError: The positions do not form a grid.
    """
    found = exact_grid(positions)
    ys, xs = _filled(found.y_mm, "y", notes), _filled(found.x_mm, "x", notes)
    grid = SurveyGrid(found.polarization_deg, ys, xs)
    if grid.cells > MAX_CELLS_PER_TRACE * len(positions):
        raise DamagedSurveyError(
            Message(
                "{count} samples lie at {columns} different x and {rows} different y, which is "
                "not a grid; give the folder of the survey, whose log describes the grid",
                count=len(positions),
                columns=len(grid.x_mm),
                rows=len(grid.y_mm),
            ),
            fault=faults.INPUT,
        )
    return grid


def _ascending(values: Sequence[float]) -> Tuple[float, ...]:
    # Coordinates that round to the same value are one; the first is used unrounded.
    found: Dict[float, float] = {}
    for value in values:
        found.setdefault(round(value, DECIMALS) + 0.0, value)
    return tuple(found[key] for key in sorted(found))


def _filled(values: Tuple[float, ...], name: str, notes: List[Message]) -> Tuple[float, ...]:
    if len(values) < 3:
        return values
    spacings = np.diff(values)
    steps = spacings / spacings.min()
    whole = np.round(steps)
    if np.abs(steps - whole).max() > EVEN or whole.sum() > MAX_FILLING * len(values):
        notes.append(
            Message(
                "the spacing along {axis} is uneven: {smallest_mm:g} to {largest_mm:g} mm",
                axis=name,
                smallest_mm=spacings.min(),
                largest_mm=spacings.max(),
            )
        )
        return values
    if whole.max() == 1.0:
        return values
    filled: List[float] = [values[0]]
    for lower, upper, parts in zip(values, values[1:], whole.astype(int)):
        filled += [lower + (upper - lower) * part / parts for part in range(1, parts)] + [upper]
    notes.append(
        Message(
            "{count} positions along {axis} without any sample were inserted to make the spacing "
            "even",
            count=len(filled) - len(values),
            axis=name,
        )
    )
    return tuple(filled)
