"""What is shown of a survey: its area, its measured stops and its lines."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy as np

from gpr20_survey.plan.imported import measured_area
from gpr20_survey.trace.trace import Trace
from gpr20_visualization.mid.line_image import LineImage
from gpr20_visualization.mid.robot_model import MM_PER_M

Place = Tuple[float, float]


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
