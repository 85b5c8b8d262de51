"""GROUND without widgets: what is chosen, where the crosshair is, and what is shown."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Optional, Tuple, Union

import numpy as np

from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.grid import Place, Stop
from gpr20_operator.ground.sources import (
    DEPTH_STEP_M,
    Axis,
    EchoSource,
    FocusedSource,
    Layer,
    Picture,
    RadarSettings,
    RadarSource,
)
from gpr20_operator.ground.traces import ShownSurvey
from gpr20_operator.jobs.pictures import Imaging
from gpr20_survey.plan.markers import Marker
from gpr20_survey.radar import ANY_SOIL
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import Candidate

Found = Union[Candidate, Marker]


@dataclass(frozen=True)
class Shown:
    """The pictures at a moment; None: nothing to show.

    Attributes:
        level_db: Level at the crosshair [dB above noise].
        section: The section through the crosshair.
        above: The image from above, at the depth of the crosshair.
    """

    level_db: Optional[float]
    section: Optional[Picture]
    above: Optional[Picture]


class GroundModel:
    """Belongs to one thread.

    Until the operator chooses a place, the crosshair follows the trace that came last; in a
    focused image, and once everything is measured, it is at the first candidate.

    Attributes:
        survey: What is shown.
        settings: How it is shown.
        mark: The candidate or marker that was touched; None: a place, or nothing.
    """

    def __init__(self, survey: ShownSurvey, additions: AdditionsPresenter) -> None:
        self.additions = additions
        self.settings = RadarSettings()
        self._focused: Optional[FocusedSource] = None
        self._chosen: Optional[Place] = None
        self.mark: Optional[Found] = None
        self.show_survey(survey)

    def show_survey(self, survey: ShownSurvey) -> None:
        """Show another survey."""
        self.survey = survey
        self._echoes = EchoSource(survey.radar)
        self._forget("")

    def show(self, settings: RadarSettings, place: Optional[Place]) -> None:
        """Show what another client chose, and nothing of what was chosen before.

        Args:
            settings: All but their permittivity.
            place: Where the crosshair is; None: it follows.
        """
        self.follow(True)
        self.settings = settings
        self.notice_survey()
        self.set_depth(settings.depth_m)
        if place is not None:
            self.choose_place(*place)

    def notice_survey(self) -> None:
        """Follow survey and permittivity, and leave a mark that is gone."""
        if self.survey.survey_id != self._survey_id:
            self._forget(self.survey.survey_id)
        grid = self.survey.radar.grid
        if grid is not None and self.settings.polarization >= len(grid.rotations_deg):
            self.change(polarization=0)
        used = self.additions.permittivity
        if used is None:
            used = ANY_SOIL.permittivity if self.image is None else self.image.found.permittivity
        if used != self.settings.permittivity:
            self.change(permittivity=used)
            self.set_depth(self.settings.depth_m)
        marks = (*self.additions.candidates, *self.additions.markers)
        if self.mark is not None and self.mark not in marks:
            self.mark = self._chosen = None

    def _forget(self, survey_id: str) -> None:
        self._survey_id = survey_id
        self._chosen = self.mark = None

    @property
    def state(self) -> Tuple[object, ...]:
        """Everything that the pictures depend on."""
        shown = self.survey
        return (
            *(shown, shown.map.revision, shown.map.current, shown.radar.revision),
            *(self.settings, self._chosen, self.mark, self.additions.revision),
        )

    @property
    def image(self) -> Optional[FocusedImage]:
        """The focused image of the survey that is shown; None: none yet."""
        return self.additions.image

    def keep_image(self, imaging: Imaging) -> None:
        """Ask for a newer image of the survey, while it is looked at."""
        stored = len(self.survey.map.stored)
        imaging.keep(self.survey.survey_id, self.additions.permittivity, stored)

    @property
    def shows_focused(self) -> bool:
        """Whether the pictures are those of the focused image."""
        return self.settings.layer is Layer.FOCUSED and self.image is not None

    @property
    def has_depth(self) -> bool:
        """Whether the view from above is that of a depth."""
        return self.settings.layer is not Layer.COVERAGE

    @property
    def waiting(self) -> Optional[np.ndarray]:
        """Which stops are stored but not here yet (bool, rows x columns); None: none is drawn."""
        number = self.settings.polarization
        waiting = self.survey.loading.waiting[number : number + 1]
        return waiting[0] if waiting.any() and not self.shows_focused else None

    @property
    def waiting_along(self) -> np.ndarray:
        """Which traces of the section wait, in the order of its places; empty: none."""
        grid, stop, waiting = self.survey.map.grid, self.stop, self.waiting
        if grid is None or stop is None or waiting is None:
            return np.zeros(0, bool)
        rows, columns = grid.ascending
        along_x = self.settings.along is Axis.X_MM
        return waiting[stop.row, columns] if along_x else waiting[rows, stop.column]

    @property
    def is_partial(self) -> bool:
        """Whether a part of the survey is not measured."""
        states = self.survey.map.stop_states
        return states is None or bool((states != StopState.DONE).any())

    @property
    def _source(self) -> RadarSource:
        image = self.image
        if image is None or self.settings.layer is not Layer.FOCUSED:
            return self._echoes
        if self._focused is None or self._focused.image is not image:
            self._focused = FocusedSource(image, self._focused)
        return self._focused

    def pictures(self) -> Shown:
        """Return what is shown now."""
        source, settings, place = self._source, self.settings, self.place
        above = source.slice(settings) if self.has_depth else None
        section = None if place is None else source.section(place, settings)
        across_mm, depth_mm = self.section_crosshair
        level_db = None
        if section is not None and across_mm is not None:
            level_db = section.level_db(across_mm, depth_mm)
        return Shown(level_db, section, above)

    @property
    def follows(self) -> bool:
        """Whether the crosshair follows the trace that came last."""
        return self._chosen is None

    @property
    def place(self) -> Optional[Place]:
        """Where the crosshair is; None before the first trace."""
        candidates, radar, place = self.additions.candidates, self.survey.radar, self._chosen
        if place is None and candidates and (self.shows_focused or not self.is_partial):
            # The newest stop may not be in the image yet.
            place = Place(candidates[0].x_mm, candidates[0].y_mm)
        # Of this polarization: the other one may not be measured yet at the newest stop.
        latest = radar.latest.get(self.settings.polarization, radar.latest.get(None))
        if place is None and radar.grid is not None and latest is not None:
            place = radar.grid.place_of(latest)
        return None if place is None else self._source.nearest(place)

    @property
    def stop(self) -> Optional[Stop]:
        """The stop nearest to the crosshair."""
        grid, place = self.survey.map.grid, self._chosen or self.place
        return None if grid is None or place is None else grid.closest_stop(*place)

    @property
    def point(self) -> Optional[Tuple[float, float, Optional[float]]]:
        """What a marker or a finer survey is for: X, Y and depth [mm]; depth None: not known."""
        if self.mark is not None:
            return self.mark.x_mm, self.mark.y_mm, self.mark.depth_mm
        place = self.place or self._chosen
        if place is None:
            return None
        depth_mm = self.settings.depth_m * 1000.0 if self.has_depth else None
        return place.x_mm, place.y_mm, depth_mm

    def choose_place(self, x_mm: float, y_mm: float, depth_mm: Optional[float] = None) -> None:
        """Move the crosshair to a place; depth None: as deep as it is."""
        # A survey that is noticed later would take the place away again.
        self.notice_survey()
        self.mark = None
        place = Place(x_mm, y_mm)
        self._chosen = self._source.nearest(place) or place
        if depth_mm is not None:
            self.set_depth(depth_mm / 1000.0)

    def choose_mark(self, mark: Found) -> None:
        """Move the crosshair to a candidate or a marker."""
        self.choose_place(mark.x_mm, mark.y_mm, mark.depth_mm)
        self.mark = mark

    def choose_next(self) -> None:
        """Go to the candidate, or the unfinished stop, after the one that is chosen."""
        candidates = self.additions.candidates
        if candidates:
            number = candidates.index(self.mark) + 1 if self.mark in candidates else 0
            self.choose_mark(candidates[number % len(candidates)])
        else:
            self.choose_next_problem()

    def choose_next_problem(self) -> None:
        """Go to the unfinished stop after the one that is chosen."""
        ground = self.survey.map
        stop = ground.next_problem(None if self.follows else self.stop)
        if stop is not None and ground.grid is not None:
            self.choose_place(*ground.grid.place_of(stop))

    def follow(self, follows: bool) -> None:
        """Let the crosshair follow the trace that came last, or stay where it is."""
        self.mark, self._chosen = None, None if follows else self.place

    def touch_section(self, across_mm: float, depth_mm: float) -> None:
        """Move the crosshair to a place and a depth of the section."""
        if self.place is not None:
            along_x = self.settings.along is Axis.X_MM
            place = (across_mm, self.place.y_mm) if along_x else (self.place.x_mm, across_mm)
            self.choose_place(*place, depth_mm)

    def change(self, **changes: Any) -> None:
        """Change some of the settings, by their names."""
        self.settings = dataclasses.replace(self.settings, **changes)

    def turn(self) -> None:
        """Show the section along the other axis."""
        along_x = self.settings.along is Axis.X_MM
        self.change(along=Axis.Y_MM if along_x else Axis.X_MM)

    def next_polarization(self) -> None:
        """Show the next antenna rotation."""
        grid = self.survey.radar.grid
        count = 1 if grid is None else len(grid.rotations_deg)
        self.change(polarization=(self.settings.polarization + 1) % count)

    @property
    def deepest_m(self) -> Optional[float]:
        """The largest depth that can be chosen [m]; None while no depth is known."""
        return self._source.deepest_m(self.settings)

    def set_depth(self, depth_m: float) -> None:
        """Move crosshair and view from above to a depth [m], on a step, as far as is shown."""
        deepest = self.deepest_m
        steps = round(depth_m / DEPTH_STEP_M)
        last = steps if deepest is None else int(deepest / DEPTH_STEP_M + 1e-6)
        self.change(depth_m=round(max(0, min(steps, last)) * DEPTH_STEP_M, 4))

    def step_depth(self, steps: int) -> None:
        """Move the depth by steps."""
        self.mark = None
        self.set_depth(self.settings.depth_m + steps * DEPTH_STEP_M)

    @property
    def section_crosshair(self) -> Tuple[Optional[float], float]:
        """The crosshair on both axes of the section [mm]; None: not known."""
        place, along_x = self.place, self.settings.along is Axis.X_MM
        across_mm = None if place is None else place.x_mm if along_x else place.y_mm
        return across_mm, self.settings.depth_m * 1000.0

    def is_measured(self, x_mm: float, y_mm: float) -> bool:
        """Return whether something is stored of the ground at a place."""
        grid, states = self.survey.map.grid, self.survey.map.stop_states
        if grid is None or states is None:
            return True
        stop = grid.nearest_stop(x_mm, y_mm)
        return stop is not None and bool(states[stop] in (StopState.DONE, StopState.PARTLY))
