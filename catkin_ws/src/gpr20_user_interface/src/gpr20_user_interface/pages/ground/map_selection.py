"""What the operator touched on the map: a stop, a candidate or a marker."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Tuple, Union

from gpr20_operator.ground.grid import Cell, SurveyGrid
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate

Mark = Union[Candidate, Marker]


@dataclass(frozen=True)
class Selection:
    """A place that was touched.

    Attributes:
        cell: The nearest stop, and which polarization of it is shown.
        mark: The candidate or marker that was touched; None: the stop itself.
        x_mm: The place along X: that of the mark, else that of the stop.
        y_mm: The place along Y.
    """

    cell: Cell
    mark: Optional[Mark]
    x_mm: float
    y_mm: float

    @property
    def depth_mm(self) -> Optional[float]:
        """Depth of the mark; None if there is none."""
        return None if self.mark is None else self.mark.depth_mm

    @property
    def candidate(self) -> Optional[Candidate]:
        """The candidate that was touched."""
        return self.mark if isinstance(self.mark, Candidate) else None

    @property
    def marker(self) -> Optional[Marker]:
        """The marker that was touched."""
        return self.mark if isinstance(self.mark, Marker) else None


def select_cell(grid: SurveyGrid, cell: Cell) -> Selection:
    """Return the selection of a stop."""
    x_mm, y_mm = grid.xs_mm[cell.stop.column], grid.ys_mm[cell.stop.row]
    return Selection(cell, None, float(x_mm), float(y_mm))


def select_mark(grid: SurveyGrid, mark: Mark, polarization: int = 0) -> Selection:
    """Return the selection of a candidate or marker, wherever it is."""
    stop = grid.closest_stop(mark.x_mm, mark.y_mm)
    return Selection(Cell(stop, polarization), mark, mark.x_mm, mark.y_mm)


def select_place(
    grid: SurveyGrid,
    marks: Tuple[Mark, ...],
    place_mm: Tuple[float, float],
    reach_mm: float,
    before: Optional[Selection] = None,
) -> Selection:
    """Return what a finger touches: a mark within reach, else the nearest stop.

    Marks that lie close together are chosen one after the other, and then the stop.

    Args:
        grid: The plan of the survey.
        marks: Candidates and markers.
        place_mm: Where the finger is.
        reach_mm: How far from a mark it may be.
        before: What was selected before.
    """
    number = 0 if before is None else before.cell.polarization
    near = _near(marks, place_mm, reach_mm)
    last = None if before is None else before.mark
    after = near if last is None or last not in near else near[near.index(last) + 1 :]
    if after:
        return select_mark(grid, after[0], number)
    return select_cell(grid, Cell(grid.closest_stop(*place_mm), number))


def next_candidate(
    candidates: Tuple[Candidate, ...], before: Optional[Selection]
) -> Optional[Candidate]:
    """Return the candidate after the one that is selected; None if there is none at all."""
    if not candidates:
        return None
    last = None if before is None else before.candidate
    number = candidates.index(last) + 1 if last in candidates else 0
    return candidates[number % len(candidates)]


def _near(marks: Tuple[Mark, ...], place_mm: Tuple[float, float], reach_mm: float) -> List[Mark]:
    x_mm, y_mm = place_mm
    found = [
        (math.hypot(one.x_mm - x_mm, one.y_mm - y_mm), number) for number, one in enumerate(marks)
    ]
    return [marks[number] for distance_mm, number in sorted(found) if distance_mm <= reach_mm]
