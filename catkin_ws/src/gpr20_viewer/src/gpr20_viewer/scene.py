"""What the views show together: one place, one image, one line of traces, and the marks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

import numpy as np

from gpr20_analysis.dataset import A_SCAN, DELAY, MM_PER_M, POLARIZATION, X, Y
from gpr20_analysis.processing.delay import to_time
from gpr20_common.message import Message
from gpr20_survey.radar import Window, decibels
from gpr20_viewer.picks import Pick
from gpr20_viewer.positions import Line, Place
from gpr20_viewer.session import NS_PER_S, LiveImage, ViewSession

MOST_CELLS = 4000
"""Largest number of cells along an axis of a picture."""
PADDING = 3.0
SINGLE_STEP_M = 0.005
"""Step of the cursor along an axis with one position."""


@dataclass(frozen=True)
class Picture:
    """Levels on an even grid.

    Attributes:
        levels_db: Levels (down, across) [dB]; NaN: not measured.
        across: Place of the first and the last column [mm].
        down: Place of the first and the last row [mm or ns].
    """

    levels_db: np.ndarray
    across: Tuple[float, float]
    down: Tuple[float, float]

    @staticmethod
    def of(levels_db: np.ndarray, across: np.ndarray, down: np.ndarray) -> Picture:
        """Return the picture of levels at positions that may be uneven: the nearest is drawn."""
        rows, columns = _even(down), _even(across)
        return Picture(
            levels_db[rows][:, columns],
            (float(across[0]), float(across[-1])),
            (float(down[0]), float(down[-1])),
        )


def traces_picture(
    session: ViewSession, line: Line, turn: int, background: bool, until_s: float
) -> Picture:
    """Return the envelopes of the traces of a line over the delay.

    Levels are relative to the brightest one that is shown.

    Args:
        session: The survey.
        line: The line.
        turn: Index of the polarization.
        background: Whether the background is subtracted.
        until_s: Last delay [s].
    """
    other = Y if line.along == X else X
    data = session.data(background)
    row = int(np.argmin(np.abs(data[other].values - line.other_m)))
    in_time = to_time(data.isel({POLARIZATION: [turn], other: [row]}), Window.HANN, PADDING)
    in_time = in_time.sel({DELAY: in_time[DELAY].values <= until_s})
    delay_ns = in_time[DELAY].values * NS_PER_S
    values = np.abs(in_time[A_SCAN].transpose(POLARIZATION, other, DELAY, line.along).values[0, 0])
    levels_db = decibels(values, 1e-300)
    if np.isfinite(levels_db).any():
        levels_db -= np.nanmax(levels_db)
    return Picture.of(levels_db.astype(np.float32), line.position_m * MM_PER_M, delay_ns)


def section_picture(image: LiveImage, turn: int, along: str, at_m: float) -> Picture:
    """Return a vertical section of an image along "x" or "y"."""
    levels_db = image.levels_db[turn]
    if along == X:
        levels_db = levels_db[:, _nearest(image.y_m, at_m), :]
        across_m = image.x_m
    else:
        levels_db = levels_db[:, :, _nearest(image.x_m, at_m)]
        across_m = image.y_m
    return Picture.of(levels_db, across_m * MM_PER_M, image.depth_m * MM_PER_M)


def slice_picture(image: LiveImage, turn: int, depth_m: Optional[float]) -> Picture:
    """Return a horizontal slice of an image; without a depth, the maximum over all of them."""
    levels_db = image.levels_db[turn]
    across = levels_db.max(axis=0)
    if depth_m is not None:
        across = levels_db[_nearest(image.depth_m, depth_m)]
    return Picture.of(across, image.x_m * MM_PER_M, image.y_m * MM_PER_M)


def longest_delay_s(
    line: Line, deepest_m: float, permittivity: float, separation_m: float
) -> float:
    """Return the delay down to which traces are shown: the deepest layer, and a little more [s]."""
    middle = len(line.position_m) // 2
    at_m = float(line.position_m[middle])
    x_m, y_m = (at_m, line.other_m) if line.along == X else (line.other_m, at_m)
    delays_s = line.delays_s(Place(x_m, y_m, deepest_m), permittivity, separation_m)
    return 1.15 * float(delays_s[middle])


def _even(places: np.ndarray) -> np.ndarray:
    """Return the index of the nearest place for each cell of an even grid."""
    if len(places) < 3:
        return np.arange(len(places))
    smallest = float(np.min(np.diff(places)))
    count = 1 + round((places[-1] - places[0]) / smallest) if smallest > 0.0 else len(places)
    even = np.linspace(places[0], places[-1], min(count, MOST_CELLS))
    return np.abs(np.searchsorted((places[1:] + places[:-1]) / 2.0, even))


def _nearest(places: np.ndarray, at: float) -> int:
    return int(np.argmin(np.abs(places - at)))


@dataclass(frozen=True)
class Mark:
    """A named place in a picture [mm, mm or ns]."""

    across: float
    down: float
    name: str = ""


class Scene:
    """A place of a survey as all views show it.

    Args:
        session: The survey.
        image: The image that is shown; None: there is none.
        place: Where the cursor is.
        turn: Index of the polarization.
        along: Direction of B-scan and section, "x" or "y".
        permittivity: Relative permittivity that is set; the image may still have another one.

    Attributes:
        line: The line of traces through the place.
    """

    def __init__(
        self,
        session: ViewSession,
        image: Optional[LiveImage],
        place: Place,
        turn: int,
        along: str,
        permittivity: float,
    ) -> None:
        self.session, self.image, self.place = session, image, place
        self.turn, self.along = turn, along
        self.permittivity = permittivity
        self.separation_m = session.options.separation_m
        self.line: Line = session.line(turn, along, self.other_of(place))

    @property
    def polarization_deg(self) -> float:
        """Rotation of the antennas [deg]."""
        return self.session.rotations_deg[self.turn]

    def along_of(self, place: Place) -> float:
        """Return where a place is along the line [m]."""
        return place.x_m if self.along == X else place.y_m

    def other_of(self, place: Place) -> float:
        """Return where a place is on the other axis [m]."""
        return place.y_m if self.along == X else place.x_m

    def moved(self, columns: int, rows: int, layers: int) -> Place:
        """Return the place some steps away: of the survey, and of the image downwards."""
        layer_m = SINGLE_STEP_M
        if self.image is not None:
            layer_m = float(self.image.depth_m[1] - self.image.depth_m[0])
        return Place(
            self.place.x_m + columns * self._step_m(X),
            self.place.y_m + rows * self._step_m(Y),
            self.place.depth_m + layers * layer_m,
        )

    def inside(self, place: Place) -> Place:
        """Return the nearest place inside the survey and the layers of the image."""
        x_m, y_m = (self.session.axis_m(axis) for axis in (X, Y))
        return Place(
            float(np.clip(place.x_m, x_m.min(), x_m.max())),
            float(np.clip(place.y_m, y_m.min(), y_m.max())),
            float(np.clip(place.depth_m, 0.0, self.session.deepest_m)),
        )

    def delay_ns(self, place: Place, permittivity: Optional[float] = None) -> float:
        """Return the two-way delay of a place where the line passes it [ns]."""
        delays_s = self.line.delays_s(place, permittivity or self.permittivity, self.separation_m)
        return NS_PER_S * float(np.interp(self.along_of(place), self.line.position_m, delays_s))

    def level_db(self, place: Place) -> Optional[float]:
        """Return the level of the image that is shown at a place [dB]; None: no image."""
        if self.image is None:
            return None
        image = self.image
        at = ((image.depth_m, place.depth_m), (image.y_m, place.y_m), (image.x_m, place.x_m))
        nearest = [int(np.argmin(np.abs(axis - one))) for axis, one in at]
        return float(image.levels_db[tuple([self.turn, *nearest])])

    def read_out(self, place: Place) -> Message:
        """Return position, delay and level of a place."""
        level_db = self.level_db(place)
        return Message(
            "x {x_mm:.0f} mm, y {y_mm:.0f} mm, depth {depth_mm:.0f} mm, delay {delay_ns:.2f} ns, "
            "level {level} dB",
            x_mm=place.x_m * MM_PER_M,
            y_mm=place.y_m * MM_PER_M,
            depth_mm=place.depth_m * MM_PER_M,
            delay_ns=self.delay_ns(place),
            level="-" if level_db is None else f"{round(level_db, 1) + 0.0:.1f}",
        )

    def in_traces(self, across_mm: float, delay_ns: float) -> Place:
        """Return the place straight below a point of the B-scan."""
        depth_m = self.line.depth_m(
            across_mm / MM_PER_M,
            delay_ns / NS_PER_S,
            self.permittivity,
            self.separation_m,
            self.session.deepest_m,
        )
        return self.in_section(across_mm, depth_m * MM_PER_M)

    def in_section(self, across_mm: float, depth_mm: float) -> Place:
        """Return the place of a point of the section."""
        along_m, other_m = across_mm / MM_PER_M, self.other_of(self.place)
        x_m, y_m = (along_m, other_m) if self.along == X else (other_m, along_m)
        return Place(x_m, y_m, depth_mm / MM_PER_M)

    def in_slice(self, x_mm: float, y_mm: float) -> Place:
        """Return the place of a point of the slice."""
        return Place(x_mm / MM_PER_M, y_mm / MM_PER_M, self.place.depth_m)

    def pick_marks(self, picks: Sequence[Pick]) -> Tuple[List[Mark], List[Mark], List[Mark]]:
        """Return the marks of picks in B-scan, section and slice.

        Those of another polarization are left out; B-scan and section show those near the line.
        """
        in_traces, in_section, in_slice = [], [], []
        near_m = self._step_m(Y if self.along == X else X)
        now = self.permittivity if self.image is None else self.image.permittivity
        for one in picks:
            if one.polarization_deg != self.polarization_deg:
                continue
            place = Place(one.x_m, one.y_m, one.depth_m)
            in_slice.append(Mark(one.x_m * MM_PER_M, one.y_m * MM_PER_M, one.id))
            if abs(self.other_of(place) - self.line.other_m) > near_m:
                continue
            across_mm = self.along_of(place) * MM_PER_M
            # The same delay is another depth at another permittivity.
            depth_mm = one.depth_m * math.sqrt(one.permittivity / now) * MM_PER_M
            in_section.append(Mark(across_mm, depth_mm, one.id))
            in_traces.append(Mark(across_mm, self.delay_ns(place, one.permittivity), one.id))
        return in_traces, in_section, in_slice

    def candidate_marks(self) -> Tuple[List[Mark], List[Mark]]:
        """Return the marks of the candidates that tables show, in section and slice."""
        in_section, in_slice = [], []
        near_m = self._step_m(Y if self.along == X else X)
        for one in () if self.image is None else self.image.candidates.shown():
            place = Place(one.x_m, one.y_m, one.depth_m)
            in_slice.append(Mark(one.x_m * MM_PER_M, one.y_m * MM_PER_M, one.id))
            if abs(self.other_of(place) - self.other_of(self.place)) <= near_m:
                across_mm = self.along_of(place) * MM_PER_M
                in_section.append(Mark(across_mm, one.depth_m * MM_PER_M, one.id))
        return in_section, in_slice

    def _step_m(self, axis: str) -> float:
        places_m = self.session.axis_m(axis)
        return float(np.min(np.diff(places_m))) if len(places_m) > 1 else SINGLE_STEP_M
