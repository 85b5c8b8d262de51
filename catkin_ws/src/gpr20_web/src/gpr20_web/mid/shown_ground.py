"""One survey as browsers see it: what they choose is worked out once for all of them."""

from __future__ import annotations

import math
import struct
import zlib
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, List, Literal, Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_operator.ground import texts
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.grid import Area, Place
from gpr20_operator.ground.model import GroundModel, Shown
from gpr20_operator.ground.sources import MAX_DEPTH_M, Axis, Layer, Picture, RadarSettings
from gpr20_operator.ground.texts import GroundMark, marks_above, marks_in_section
from gpr20_operator.ground.traces import (
    RETRY_S,
    ShownSurvey,
    TracePresenter,
)
from gpr20_operator.jobs.job import JobState
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.palette import (
    LAST_SHADE,
    Theme,
    pattern,
    pattern_colours,
    shade_colours,
    shade_numbers,
)
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.trace.trace import MAX_COORDINATE
from gpr20_web.calls import Text
from gpr20_web.faults import NotFoundError

MM_PER_M = 1000.0
# Another screen may have entered what the ground is, or set a marker [s].
AGAIN_S = 10.0
# What was worked out last; more choices than this at once are worked out again.
MOST_KEPT = 24
# Longer side of a picture of cells [px].
PATTERN_PX = 480
# Single stops that failed must not be overlooked among thousands.
MAX_RINGS = 60
NOTHING = Message("there is nothing to show yet")
# Of a PNG; the fastest compression: a picture is looked at for a second.
BITS, PALETTE, COMPRESSION = 8, 3, 1


@dataclass(frozen=True)
class GroundChoice:
    """What a browser wants to see of a survey; without a place, that of the last trace."""

    theme: Theme = Theme.SUN
    layer: Literal["coverage", "echoes", "focused"] = "echoes"
    along: Literal["x", "y"] = "x"
    polarization: int = bounded(0, 64, 0)
    depth_mm: float = bounded(0.0, MAX_DEPTH_M * MM_PER_M, RadarSettings.depth_m * MM_PER_M)
    x_mm: Optional[float] = bounded(-MAX_COORDINATE, MAX_COORDINATE, None)
    y_mm: Optional[float] = bounded(-MAX_COORDINATE, MAX_COORDINATE, None)

    @property
    def settings(self) -> RadarSettings:
        """All but the permittivity, which is that of the survey."""
        return RadarSettings(
            polarization=self.polarization,
            depth_m=self.depth_mm / MM_PER_M,
            along=Axis(self.along),
            layer=Layer(self.layer),
        )

    @property
    def place(self) -> Optional[Place]:
        """The place, as in a GroundModel."""
        if self.x_mm is None or self.y_mm is None:
            return None
        return Place(self.x_mm, self.y_mm)


class ShownGround:
    """The running survey, or a past one. Belongs to one thread.

    Args:
        imaging: Asks for traces and images of this survey; its pictures are those of all.
        report: Called with the reason why a trace or a survey cannot be shown.
        opened: Folder of a past survey; empty: the one that runs.

    Attributes:
        used_s: When a browser asked for it last.
        is_outdated: Whether its markers are to be read again.
    """

    def __init__(
        self,
        imaging: Imaging,
        report: Callable[[Message], None],
        opened: str = "",
    ) -> None:
        self.opened, self._report = opened, report
        self.imaging = imaging
        self.traces = TracePresenter(imaging, self._note)
        self.additions = AdditionsPresenter(imaging, lambda: "")
        self.model = GroundModel(self.traces.shown, self.additions)
        self.used_s, self.is_outdated = -math.inf, False
        self._noted: Optional[Message] = None
        self._kept: OrderedDict[Tuple[object, ...], Any] = OrderedDict()
        self._open()

    @property
    def shown(self) -> ShownSurvey:
        """What is known of the survey."""
        return self.traces.shown

    @property
    def survey_id(self) -> str:
        """The survey; empty: it is not known yet."""
        return self.shown.survey_id

    @property
    def listed(self) -> Optional[SurveySummary]:
        """The survey in the list of the stored ones; None: the list has not come yet."""
        found = (one for one in self.traces.past.surveys if one.survey_id == self.survey_id)
        return next(found, None)

    @property
    def folder(self) -> str:
        """That of the survey; empty: it is not known yet."""
        return self.opened or ("" if self.listed is None else self.listed.folder)

    @property
    def revision(self) -> str:
        """Changes with everything that does not depend on a choice."""
        shown = self.shown
        numbers = shown.map.revision, shown.radar.revision, *self.additions.revision
        return "-".join([self.survey_id[:8], *map(str, numbers)])

    def on_event(self, event: object) -> None:
        """Take what belongs to this survey."""
        if not self.opened:
            self.traces.on_event(event)
            self._follow()

    def refresh(self) -> None:
        """Take what has come, and ask for what is missing."""
        opening = self.traces.opening
        if opening.state is JobState.FAILED and opening.age_s >= RETRY_S:
            self._open()
        self.traces.refresh()
        self._follow()
        self.additions.refresh(AGAIN_S)
        if self.is_outdated:
            self.is_outdated = False
            self.additions.read_again()
        if self.traces.past.outdated:
            self.traces.past.outdated = False
            self.traces.list_surveys()

    def _open(self) -> None:
        if self.opened:
            self.traces.list_surveys()
            self.traces.open_survey(self.opened)

    def _follow(self) -> None:
        """Show the survey that the traces are of, with what belongs to it and nothing else."""
        shown = self.traces.shown
        if shown is not self.model.survey:
            self.model.show_survey(shown)
        self.additions.follow(shown.map.grid)
        self.model.notice_survey()

    def _show(self, choice: GroundChoice) -> Shown:
        """Let the model show a choice, and return its pictures."""
        self._follow()
        self.model.show(choice.settings, choice.place)
        shown: Shown = self._once(self.model.state[1:], self.model.pictures)
        return shown

    def png(self, kind: str, choice: GroundChoice) -> bytes:
        """Return a map, a section, or the bar of colours, the strongest at the top.

        Raises:
            NotFoundError: It has nothing to show.
        """
        if kind == "bar":
            bar = np.arange(LAST_SHADE, -1, -1, dtype=np.uint8)[:, None]
            return png_of(bar, shade_colours())
        shown, model = self._show(choice), self.model
        if kind == "map" and not model.has_depth:
            cells = self.shown.map.cells(model.waiting)
            if cells is None:
                raise NotFoundError(NOTHING)
            return png_of(pattern(cells, PATTERN_PX), pattern_colours(choice.theme))
        picture = shown.section if kind == "section" else shown.above
        if picture is None:
            raise NotFoundError(NOTHING)
        # Y goes up, and depth goes down.
        shades = picture.shades[:: 1 if kind == "section" else -1]
        key = (kind, *model.state[1:])
        return bytes(self._once(key, lambda: png_of(shade_numbers(shades), shade_colours())))

    def document(self, choice: GroundChoice, text: Text) -> Dict[str, Any]:
        """Return a choice of the survey for a browser; areas are left, right, low and high."""
        shown, model = self._show(choice), self.model
        survey, settings, place = model.survey.map, model.settings, model.place
        counts, deepest_m = survey.counts(), model.deepest_m
        picture = shown.above or shown.section
        return {
            "counts": [
                [text(name), None if counts is None else counts[state]]
                for state, name in texts.STATE_NAMES.items()
            ],
            "polarization": settings.polarization,
            "depth_mm": round(settings.depth_m * MM_PER_M),
            "deepest_mm": None if deepest_m is None else round(deepest_m * MM_PER_M),
            "notes": _said((*texts.notes(model), texts.remark(model)), text),
            "notice": _said(texts.above_notice(model, shown, self.imaging.problem), text),
            "lines": _said(texts.touched_lines(model, shown), text),
            "place": None if place is None else list(place),
            "marks": [_mark(one, text) for one in marks_above(model)],
            "bar": [] if picture is None else picture.scale.ticks().tolist(),
            "image": None if shown.above is None else _extent(shown.above),
            "section": _section(model, shown.section, text),
            **_plan(model, text),
        }

    def _once(self, key: Tuple[object, ...], make: Callable[[], Any]) -> Any:
        """Return what was made for the same key and survey, or make it."""
        whole = (self.survey_id, *key)
        if whole not in self._kept:
            self._kept[whole] = make()
        self._kept.move_to_end(whole)
        while len(self._kept) > MOST_KEPT:
            self._kept.popitem(last=False)
        return self._kept[whole]

    @property
    def problem(self) -> Optional[Message]:
        """Why it cannot be shown, or not all of it; None: nothing went wrong."""
        return self.traces.opening.problem or self._noted

    def _note(self, problem: Message) -> None:
        if problem != self._noted:
            self._report(problem)
        self._noted = problem


def png_of(numbers: np.ndarray, colours: np.ndarray) -> bytes:
    """Return a picture of numbers, each of which has a colour, as a PNG file.

    Args:
        numbers: Number of the colour of each pixel, row by row from the top (uint8).
        colours: Red, green, blue and alpha of each number (uint8, at most 256 x 4).
    """
    height, width = numbers.shape
    # Each row begins with the number of its filter, which is none.
    rows = np.pad(numbers, ((0, 0), (1, 0)))
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, BITS, PALETTE, 0, 0, 0)),
        (b"PLTE", colours[:, :3].tobytes()),
        (b"tRNS", colours[:, 3].tobytes()),
        (b"IDAT", zlib.compress(rows.tobytes(), COMPRESSION)),
        (b"IEND", b""),
    )
    parts = [b"\x89PNG\r\n\x1a\n"]
    for kind, content in chunks:
        sum_ = zlib.crc32(kind + content)
        parts += [struct.pack(">I", len(content)), kind, content, struct.pack(">I", sum_)]
    return b"".join(parts)


def _plan(model: GroundModel, text: Text) -> Dict[str, Any]:
    """Return what follows from the plan of the survey."""
    grid = model.survey.map.grid
    if grid is None:
        return {"area": None}
    rotations = (Message("{rotation:g}°", rotation=one) for one in grid.rotations_deg)
    return {
        "polarizations": list(map(text, rotations)),
        "area": _area(grid.area),
        "steps_mm": list(grid.spacing_mm),
        "failed": list(map(list, model.survey.map.failed(MAX_RINGS))),
    }


def _section(
    model: GroundModel, picture: Optional[Picture], text: Text
) -> Optional[Dict[str, Any]]:
    if picture is None:
        return None
    across, second = texts.section_title(model)
    return {
        "extent": _extent(picture),
        "titles": [across, text(second)],
        "notice": _said(texts.nothing_in(model, picture, True), text),
        "at": list(model.section_crosshair),
        "columns": picture.levels_db.shape[1],
        "loading": np.flatnonzero(model.waiting_along).tolist(),
        "marks": [_mark(one, text) for one in marks_in_section(model)],
    }


def _mark(mark: GroundMark, text: Text) -> Dict[str, Any]:
    about: Any = mark.about
    is_candidate = isinstance(about, Candidate)
    lines = (
        texts.candidate_lines(about, mark.measured) if is_candidate else texts.marker_lines(about)
    )
    return {
        "at": [mark.across_mm, mark.second_mm],
        "number": mark.text,
        "candidate": is_candidate,
        "doubtful": mark.doubtful or not mark.measured,
        "near": mark.near,
        "place": [about.x_mm, about.y_mm, about.depth_mm],
        "lines": _said(lines, text),
    }


def _area(area: Area) -> List[float]:
    return [area.left_mm, area.right_mm, area.low_mm, area.high_mm]


def _extent(picture: Picture) -> List[float]:
    return [*picture.across_mm, *picture.range]


def _said(lines: Iterable[Message], text: Text) -> List[str]:
    return [one[:1].upper() + one[1:] for one in map(text, lines) if one]
