"""What is shown of a survey: its area, its measured stops, its lines as grey pictures (B-scans)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_survey.plan.recorded_plan import measured_area
from gpr20_survey.radar import FrequencyToDelay, decibels, unambiguous_s
from gpr20_survey.trace.trace import Trace
from gpr20_visualization.mid.robot_model import MM_PER_M

Place = Tuple[float, float]
DELAY_STEP_S = 0.05e-9
MAX_ROWS = 200
DARKEST_DB = -60.0
WHITE = 255


def transform_of(frequency_hz: np.ndarray) -> FrequencyToDelay:
    """Return the transform of sweeps with these frequencies to the rows of a picture."""
    rows = int(unambiguous_s(frequency_hz) / DELAY_STEP_S)
    return FrequencyToDelay(frequency_hz, DELAY_STEP_S, min(MAX_ROWS, max(2, rows)))


def grey(echoes: np.ndarray) -> np.ndarray:
    """Return the picture of a line at one antenna rotation (delays x stops, uint8).

    What all stops have in common (direct wave, level surface) is removed. White is the strongest
    echo of the line before that; black is 60 dB below it, or weaker.

    Args:
        echoes: Complex echoes (stops x delays); rows of NaN were not measured.
    """
    measured = ~np.isnan(echoes[:, 0])
    levels_db = np.full(echoes.shape, DARKEST_DB)
    present = echoes[measured]
    strongest = np.abs(present).max() if len(present) else 0.0
    if strongest > 0.0:
        left = present - present.mean(axis=0) if len(present) > 1 else present
        ratio = np.abs(left) / strongest
        levels_db[measured] = decibels(ratio, 10.0 ** (DARKEST_DB / 20.0))
    shades = WHITE * (1.0 - np.minimum(levels_db, 0.0) / DARKEST_DB)
    picture: np.ndarray = np.rint(shades).astype(np.uint8).T
    return picture


def side_by_side(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Return pictures beside each other, with a white line between them."""
    between = np.full((pictures[0].shape[0], 1), WHITE, np.uint8)
    return np.hstack([part for one in pictures for part in (between, one)][1:])


class LineImage:
    """Collects the traces of one line along X, and draws them."""

    def __init__(self, transform: Optional[FrequencyToDelay] = None) -> None:
        """Begin a line; a transform of the line before saves its computation."""
        self.transform = transform
        self._echoes: Dict[Tuple[float, float], np.ndarray] = {}

    def __len__(self) -> int:
        """Return how many samples it has; one that was measured again counts once."""
        return len(self._echoes)

    def add(self, trace: Trace) -> None:
        """Add a trace; one at the same place and rotation replaces the former."""
        if self.transform is None or not self.transform.fits(trace.frequency_hz):
            self.transform = transform_of(trace.frequency_hz)
            self._echoes = {}
        s21 = trace.s21_real + 1j * trace.s21_imag
        self._echoes[trace.z_coord_deg, trace.x_coord_mm] = self.transform.transform(s21)

    def picture(self) -> np.ndarray:
        """Return the picture (delays x stops): X ascending, one part for each rotation, ascending.

        The line must have a trace.
        """
        rotations = sorted({rotation for rotation, _x in self._echoes})
        xs = sorted({x for _rotation, x in self._echoes})
        missing = np.full_like(next(iter(self._echoes.values())), np.nan)
        return side_by_side(
            [
                grey(np.array([self._echoes.get((rotation, x), missing) for x in xs]))
                for rotation in rotations
            ]
        )


@dataclass(frozen=True)
class Area:
    """The area of a survey in base_link.

    Attributes:
        start_m: First stop (x, y) [m].
        stop_m: Last stop (x, y) [m].
        line_samples: Traces of one line along X.
    """

    start_m: Place
    stop_m: Place
    line_samples: int

    def outline(self) -> List[Place]:
        """Return its corners, the first one again at the end [m]."""
        (x, y), (other_x, other_y) = self.start_m, self.stop_m
        return [(x, y), (other_x, y), (other_x, other_y), (x, other_y), (x, y)]


def area_of(description: str) -> Optional[Area]:
    """Return the area of a survey by its survey.json; None if it is not known."""
    try:
        values: Mapping[str, Any] = measured_area(json.loads(description))
        rotations = values["polarizations_deg"]
        return Area(
            (values["x_start_mm"] / MM_PER_M, values["y_start_mm"] / MM_PER_M),
            (values["x_stop_mm"] / MM_PER_M, values["y_stop_mm"] / MM_PER_M),
            int(values["x_points"]) * len(rotations),
        )
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
        return None


class SurveyPicture:
    """Follows the traces of a survey; a trace of another survey begins a new one."""

    def __init__(self) -> None:
        self._survey_id = ""
        self._area: Optional[Area] = None
        self._line = LineImage()
        self._y_mm = 0.0
        self._shown = True
        self._last_us = self.ended_us = 0
        """Time of the last trace of the line that `add` has returned [us since 1970, UTC]."""
        self._stops: Dict[Place, None] = {}

    @property
    def stops_m(self) -> List[Place]:
        """Places of the measured stops, in their order [m]."""
        return [(x_mm / MM_PER_M, y_mm / MM_PER_M) for x_mm, y_mm in self._stops]

    def set_area(self, area: Optional[Area]) -> None:
        """Set the area of the survey whose traces come next."""
        self._area = area

    def add(self, trace: Trace) -> Optional[np.ndarray]:
        """Add a trace; return the B-scan (delays x stops, uint8) of the line that it finishes."""
        finished = None
        if trace.survey_id != self._survey_id:
            self._survey_id = trace.survey_id
            self._stops = {}
            self._begin_line(trace)
        elif trace.y_coord_mm != self._y_mm:
            finished = self._finished()
            self._begin_line(trace)
        self._stops[trace.x_coord_mm, trace.y_coord_mm] = None
        self._line.add(trace)
        self._last_us, self._shown = trace.timestamp_us, False
        if self._area is not None and len(self._line) >= self._area.line_samples:
            return self._finished()
        return finished

    def _begin_line(self, trace: Trace) -> None:
        self._line = LineImage(self._line.transform)
        self._y_mm, self._shown = trace.y_coord_mm, False

    def _finished(self) -> Optional[np.ndarray]:
        if self._shown or not len(self._line):
            return None
        self._shown, self.ended_us = True, self._last_us
        return self._line.picture()
