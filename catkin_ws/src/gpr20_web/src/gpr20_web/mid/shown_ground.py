"""One survey as browsers see it: what they choose is worked out once for all of them."""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import Any, Callable, Dict, NamedTuple, Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.cells import MARKS, TILE_PX, TILES, Cell, hiding_cells
from gpr20_operator.ground.geometry import Area, survey_area
from gpr20_operator.ground.model import IMAGES, GroundModel, Shown
from gpr20_operator.ground.records import Colours
from gpr20_operator.ground.shade_colours import LAST_SHADE, colour_table, shade_numbers
from gpr20_operator.ground.shown_survey import ShownSurvey
from gpr20_operator.ground.trace_events import (
    ReadingFailed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)
from gpr20_operator.ground.traces import TracePresenter, TraceSource
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.palette import Theme
from gpr20_web.errors import NotFoundError
from gpr20_web.mid.ground_choice import GroundChoice
from gpr20_web.mid.png import png

# What was worked out last; more choices than this at once are worked out again.
MOST_KEPT = 24
# A survey that cannot be read is asked for again after so many refreshes.
AGAIN_REFRESHES = 10
# Pixels of a cell with a pattern, by how many cells there are at most.
CELL_PX = ((4_096, 8), (65_536, 4))
# What is of a past survey; other events are of the running one.
OF_PAST = (SurveyRead, SurveysListed, TracesRead, ReadingFailed)
NOTHING = Message("there is nothing to show yet")


class Patterns(NamedTuple):
    """Cells of the ground, both axes ascending; the key changes with them."""

    key: Tuple[object, ...]
    cells: np.ndarray
    area: Area


class ShownGround:
    """The running survey, or a past one. Belongs to one thread.

    Args:
        source: The storage.
        imaging: Asks for images of this survey; its pictures are those of all.
        report: Called with the reason why a trace or a survey cannot be shown.
        opened: Folder of a past survey; empty: the one that runs.

    Attributes:
        used_s: When a browser asked for it last.
        used_by: Whose browser that was.
        problem: Why it cannot be shown, or not all of it; None: nothing went wrong.
        is_outdated: Whether its markers and related surveys are to be read again.
    """

    def __init__(
        self,
        source: TraceSource,
        imaging: Imaging,
        report: Callable[[Message], None],
        opened: str = "",
    ) -> None:
        self.opened, self._source, self._report = opened, source, report
        self.imaging = imaging
        self.traces = TracePresenter(source, self._note)
        self.additions = AdditionsPresenter(source, lambda: "", imaging.pictures)
        self.model = GroundModel(self.traces.shown, self.additions)
        self.used_s, self.used_by, self.is_outdated = -math.inf, "", False
        self.problem: Optional[Message] = None
        self._can_read = bool(opened)
        self._kept: OrderedDict[Tuple[object, ...], Any] = OrderedDict()
        self._open()

    @property
    def shown(self) -> ShownSurvey:
        """What is known of the survey."""
        return self.model.survey

    @property
    def survey_id(self) -> str:
        """The survey; empty: it is not known yet."""
        return self.shown.survey_id

    @property
    def folder(self) -> str:
        """That of the survey; empty: it is not known yet."""
        listed = (one for one in self.traces.past.surveys if one.survey_id == self.survey_id)
        return self.opened or next((one.folder for one in listed), "")

    @property
    def revision(self) -> str:
        """Changes with everything that does not depend on a choice."""
        shown = self.shown
        numbers = shown.map.revision, shown.radar.revision, *self.additions.revision
        return "-".join([self.survey_id[:8], *map(str, numbers)])

    def on_event(self, event: object) -> None:
        """Take what belongs to this survey."""
        self.additions.on_event(event)
        if isinstance(event, TracesRead) and event.block.survey_id != self.survey_id:
            return  # the answer to another one's question
        if not self.opened or isinstance(event, OF_PAST):
            self.traces.on_event(event)
        if isinstance(event, ReadingFailed) and not self.survey_id:
            self.problem, self._is_asked = event.reason, False
        self._follow()

    def refresh(self, can_read: bool) -> None:
        """Take what has come, and ask for what is missing; that of a replay cannot be read."""
        self._can_read = can_read
        self._refreshes += 1
        if not self._is_asked and self._refreshes >= AGAIN_REFRESHES:
            self._open()
        self.traces.refresh()
        self._follow()
        self.additions.refresh()
        if self.is_outdated:
            self.is_outdated = False
            self.additions.read_again()
        if self.traces.past.outdated:
            self.traces.past.outdated = False
            self._source.list_surveys("")

    def _open(self) -> None:
        self._is_asked, self._refreshes = True, 0
        if self.opened:
            self._source.list_surveys("")
            self.traces.open_survey(self.opened)

    def _follow(self) -> None:
        """Show the survey that the traces are of, with what belongs to it and nothing else."""
        shown = self.traces.shown
        if shown is not self.model.survey:
            self.model.show_survey(shown)
        self.additions.follow(shown.survey_id, self._can_read)
        grid, image = shown.map.grid, self.imaging.pictures.image(shown.survey_id)
        if grid is not None:
            # Since the plan was read somebody may have entered another one, which images have.
            soil = grid.permittivity if image is None else image.found.permittivity
            self.imaging.soils.take(grid.survey_id, soil)
            self.model.take_soil(grid.survey_id, soil)

    def show(self, choice: GroundChoice) -> Shown:
        """Let the model show a choice, and return its pictures."""
        self._follow()
        model, alongs = self.model, choice.alongs
        model.show(choice.settings, choice.layers, choice.place)
        shown: Shown = self._once((alongs, *model.state[1:]), lambda: model.pictures(alongs))
        return shown

    def png(self, kind: str, choice: GroundChoice) -> bytes:
        """Return a map, a section, or the bar of colours, the strongest at the top.

        Raises:
            NotFoundError: It has nothing to show.
        """
        shown, patterns = self.show(choice), self.patterns()
        first, picture = shown.first, shown.above
        if first is None or not first.signed:
            table = colour_table(Colours.ENVELOPE)
        else:
            table = colour_table(choice.settings.colours)
        if kind == "bar":
            return png(np.arange(LAST_SHADE + 1, dtype=np.uint8)[::-1, None], table)
        if kind == "map" and choice.layer in patterns:
            key, cells, _area = patterns[choice.layer]
            made = self._once((*key, choice.theme), lambda: pattern_png(cells, choice.theme))
        elif kind == "map" and choice.layer == "loading":
            # The last of it has arrived since the page was told that something loads.
            made = pattern_png(np.full((1, 1), Cell.BLANK, np.uint8), choice.theme)
        else:
            if kind == "section":
                picture = shown.sections[0] if shown.sections else None
            if picture is None or (kind == "map" and not choice.layers & IMAGES):
                raise NotFoundError(NOTHING)
            # Y goes up, and depth goes down.
            shades, signed = picture.shades[:: 1 if kind == "section" else -1], picture.signed
            key = (kind, choice.alongs, *self.model.state[1:])
            made = self._once(key, lambda: png(shade_numbers(shades, signed), table))
        return bytes(made)

    def patterns(self) -> Dict[str, Patterns]:
        """Return the layers that are no images, of which there is something to show."""
        shown, hiding, waiting = self.shown, self.additions.hiding, self.model.waiting
        found: Dict[str, Patterns] = {}
        key: Tuple[object, ...]
        if hiding is not None:
            key = ("hiding", *self.additions.revision)
            found["hiding"] = Patterns(key, *hiding_cells(hiding))
        grid, states = shown.map.grid, shown.map.stop_states
        if grid is not None and states is not None:
            area, key = survey_area(grid.xs_mm, grid.ys_mm), ("coverage", shown.map.revision)
            found["coverage"] = Patterns(key, states[grid.ascending], area)
            if waiting is not None:
                cells = np.where(waiting, Cell.LOADING, Cell.BLANK).astype(np.uint8)
                numbers = shown.radar.revision, self.model.settings.polarization
                found["loading"] = Patterns((*key, *numbers), cells[grid.ascending], area)
        return found

    def _once(self, key: Tuple[object, ...], make: Callable[[], Any]) -> Any:
        """Return what was made for the same key and survey, or make it."""
        whole = (self.survey_id, *key)
        if whole not in self._kept:
            self._kept[whole] = make()
        self._kept.move_to_end(whole)
        while len(self._kept) > MOST_KEPT:
            self._kept.popitem(last=False)
        return self._kept[whole]

    def _note(self, problem: Message) -> None:
        if problem != self.problem:
            self._report(problem)
        self.problem = problem


def pattern_png(cells: np.ndarray, theme: Theme, size_px: int = 0) -> bytes:
    """Return the patterns of cells (uint8); the size of a cell may follow from their number."""
    px = size_px or next((px for most, px in CELL_PX if cells.size <= most), 1)
    # The first row of a picture is the one at the top.
    wide = cells[::-1].repeat(px, axis=0).repeat(px, axis=1)
    y, x = (np.arange(size) % TILE_PX for size in wide.shape)
    colours = [bytes(4), *(bytes.fromhex(one.of(theme)[1:]) + b"\xff" for one in MARKS)]
    return png(
        TILES[wide, y[:, None], x], np.frombuffer(b"".join(colours), np.uint8).reshape(-1, 4)
    )
