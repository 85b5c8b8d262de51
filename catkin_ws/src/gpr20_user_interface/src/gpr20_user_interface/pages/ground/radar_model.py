"""The RADAR tab without its widgets: what is chosen, where the crosshair is, what is shown."""

from __future__ import annotations

import dataclasses
import enum
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.pictures import DEPTH_STEP_M
from gpr20_operator.ground.records import (
    Axis,
    Curve,
    Picture,
    Place,
    RadarSettings,
    Source,
)
from gpr20_operator.ground.sources import EchoSource, FocusedSource, RadarSource
from gpr20_survey.radar.depth import (
    delay_of_depth,
    depth_of_delay_m,
    one_way_path_m,
    two_way_delay_s,
)
from gpr20_survey.radar.hyperbola import Hyperbola
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.focused_image import FocusedImage

# Points of the hyperbola that are drawn.
HYPERBOLA_POINTS = 81


class Grip(enum.Enum):
    """What of the hyperbola is dragged."""

    APEX = "apex"
    FLANK = "flank"


@dataclass(frozen=True)
class RadarPictures:
    """What is shown at a moment; None: nothing to show.

    Args:
        place: Where the crosshair is.
        depth_m: Depth of the crosshair and the slice [m].
        level_db: Level at the crosshair [dB above noise].
        curve: The trace at the crosshair.
        line: The line through the crosshair.
        slice: The slice at the depth of the crosshair.
    """

    place: Optional[Place]
    depth_m: float
    level_db: Optional[float]
    curve: Optional[Curve]
    line: Optional[Picture]
    slice: Optional[Picture]


class RadarPresenter:
    """Belongs to one thread.

    Until the operator chooses a place, the crosshair follows the trace that came last; in a
    focused image it is at the first candidate.

    Attributes:
        model: The echoes of the survey that is shown.
        settings: What the operator chose.
        hyperbola: The hyperbola that is being fitted.
    """

    def __init__(self, model: RadarModel) -> None:
        self.settings = RadarSettings()
        self.hyperbola: Optional[Hyperbola] = None
        self._image: Optional[FocusedSource] = None
        self._planned_permittivity: Optional[float] = None
        self.show_model(model)

    def show_model(self, model: RadarModel) -> None:
        """Follow another survey."""
        self.model = model
        self._echoes = EchoSource(model)
        self._chosen: Optional[Place] = None
        self._survey = ""
        self.hyperbola = None

    @property
    def state(self) -> Tuple[object, ...]:
        """Everything that the pictures depend on."""
        image = None if self._image is None else self._image.image
        revision, settings = self.model.revision, self.settings
        return (self.model, revision, settings, self._chosen, self.hyperbola, id(image))

    @property
    def image(self) -> Optional[FocusedImage]:
        """The focused image of the survey that is shown, if there is one."""
        grid = self.model.grid
        if self._image is None or grid is None:
            return None
        image = self._image.image
        return image if image.survey_id == grid.survey_id else None

    @property
    def shows_focused(self) -> bool:
        """Whether the pictures are those of the focused image."""
        return self.settings.source is Source.FOCUSED and self.image is not None

    @property
    def candidates(self) -> Tuple[Candidate, ...]:
        """The candidates of the focused image of this survey."""
        image = self.image
        return () if image is None else image.found.shown()

    @property
    def follows(self) -> bool:
        """Whether the crosshair follows the trace that came last."""
        return self._chosen is None

    @property
    def place(self) -> Optional[Place]:
        """Where the crosshair is; None before the first trace."""
        if self._chosen is not None:
            return self._source.nearest(self._chosen)
        if self.shows_focused and self.candidates:
            # The newest stop may not be in the image yet.
            first = self.candidates[0]
            return self._source.nearest(Place(first.x_mm, first.y_mm))
        grid = self.model.grid
        # Of this polarization: the other one may not be measured yet at the newest stop.
        latest = self.model.latest_of.get(self.settings.polarization, self.model.latest)
        if grid is None or latest is None:
            return None
        x_mm, y_mm = grid.xs_mm[latest.stop.column], grid.ys_mm[latest.stop.row]
        return self._source.nearest(Place(float(x_mm), float(y_mm)))

    def set_image(self, image: Optional[FocusedImage]) -> None:
        """Take the newest focused image, of whichever survey."""
        before = self._image
        if image is None:
            self._image = None
        elif before is None or image is not before.image:
            same = before is not None and before.image.survey_id == image.survey_id
            self._image = FocusedSource(image, before.steady if same and before else None)

    def notice_survey(self) -> None:
        """Begin again if another survey has begun in the model."""
        grid = self.model.grid
        survey = "" if grid is None else grid.survey_id
        if survey != self._survey:
            self._survey = survey
            self._chosen = None
            self.hyperbola = None
        if grid is not None and self.settings.polarization >= len(grid.rotations_deg):
            self.change(polarization=0)

    def pictures(self) -> RadarPictures:
        """Return what is shown now."""
        source, settings, place = self._source, self.settings, self.place
        area = source.slice(settings)
        if place is None:
            return RadarPictures(None, settings.depth_m, None, None, None, area)
        return RadarPictures(
            place,
            settings.depth_m,
            source.level_db(place, settings),
            source.curve(place, settings),
            source.line(place, settings),
            area,
        )

    def change(self, **changes: object) -> None:
        """Change some of the settings, by their names."""
        self.settings = dataclasses.replace(self.settings, **changes)  # type: ignore[arg-type]
        if "permittivity" in changes:
            self.set_depth(self.settings.depth_m)

    def take_plan(self, permittivity: Optional[float]) -> None:
        """Use the soil of the plan when it changes; None: it is wrong, keep the last one.

        A soil that is chosen here after that stays until the plan has another one.
        """
        if permittivity is not None and permittivity != self._planned_permittivity:
            self._planned_permittivity = permittivity
            self.change(permittivity=permittivity)

    def next_polarization(self) -> None:
        """Show the next antenna rotation."""
        grid = self.model.grid
        count = 1 if grid is None else len(grid.rotations_deg)
        self.change(polarization=(self.settings.polarization + 1) % count)

    def follow(self, follows: bool) -> None:
        """Let the crosshair follow the trace that came last, or stay where it is."""
        self._chosen = None if follows else self.place

    @property
    def deepest_m(self) -> Optional[float]:
        """The largest depth that can be chosen [m]; None while no depth is known."""
        return self._source.deepest_m(self.settings)

    def set_depth(self, depth_m: float) -> None:
        """Move slice and crosshair to a depth [m], on a step and within what can be shown."""
        deepest = self.deepest_m
        steps = round(depth_m / DEPTH_STEP_M)
        last = steps if deepest is None else int(deepest / DEPTH_STEP_M + 1e-6)
        self.settings = dataclasses.replace(
            self.settings, depth_m=round(max(0, min(steps, last)) * DEPTH_STEP_M, 4)
        )

    def step_depth(self, steps: int) -> None:
        """Move slice and crosshair by steps."""
        self.set_depth(self.settings.depth_m + steps * DEPTH_STEP_M)

    def touch_slice(self, x_mm: float, y_mm: float) -> None:
        """Move the crosshair to a place of the slice."""
        self._chosen = self._source.nearest(Place(x_mm, y_mm))

    def touch_line(self, across_mm: float, second: float, axis: Axis) -> None:
        """Move the crosshair to a place of the line.

        Args:
            across_mm: Place along the line [mm].
            second: Depth [mm] or delay [ns].
            axis: What the second one is.
        """
        place = self.place
        if place is not None:
            along_x = self.settings.along is Axis.X_MM
            x_mm = across_mm if along_x else place.x_mm
            y_mm = place.y_mm if along_x else across_mm
            self._chosen = self._source.nearest(Place(x_mm, y_mm))
        self.touch_curve(second, axis)

    def touch_curve(self, second: float, axis: Axis) -> None:
        """Move the crosshair to a depth [mm] or delay [ns] of the trace."""
        depth_m = self.depth_of(second, axis)
        if depth_m is not None:
            self.set_depth(depth_m)

    def depth_of(self, second: float, axis: Axis) -> Optional[float]:
        """Return the depth [m] of a place on a second axis; None if it is not known."""
        if axis is Axis.DEPTH_MM:
            return second / 1000.0
        height_m = self.model.typical_height_m()
        if not np.isfinite(height_m):
            return None
        return depth_of_delay_m(second * 1e-9, height_m, self.settings.permittivity)

    def second_of(self, depth_m: float, axis: Axis) -> Optional[float]:
        """Return where a depth [m] is on a second axis; None if it is not known."""
        if axis is Axis.DEPTH_MM:
            return depth_m * 1000.0
        height_m = self.model.typical_height_m()
        if not np.isfinite(height_m):
            return None
        return float(delay_of_depth(depth_m, height_m, self.settings.permittivity)) * 1e9

    @property
    def can_fit(self) -> bool:
        """Whether a hyperbola can be put at the crosshair: its height must be known."""
        return self.place is not None and bool(np.isfinite(self.model.typical_height_m()))

    def begin_hyperbola(self) -> None:
        """Put a hyperbola at the crosshair, if it can be put there."""
        place, height_m = self.place, self.model.typical_height_m()
        if place is None or not self.can_fit:
            return
        settings = self.settings
        delay_s = float(delay_of_depth(settings.depth_m, height_m, settings.permittivity))
        self.hyperbola = Hyperbola(
            place.along(settings.along), delay_s, height_m, settings.permittivity
        )

    def drag_hyperbola(self, grip: Grip, across_mm: float, second: float, axis: Axis) -> None:
        """Move the apex to a point of the line, or bend the hyperbola through it."""
        hyperbola = self.hyperbola
        if hyperbola is None:
            return
        delay_s = self._delay_s(second, axis, hyperbola.height_m)
        if grip is Grip.APEX:
            self.hyperbola = dataclasses.replace(
                hyperbola, across_mm=across_mm, apex_delay_s=delay_s
            )
        else:
            self.hyperbola = hyperbola.through(across_mm, delay_s)

    def hyperbola_points(self, line: Picture) -> Tuple[np.ndarray, np.ndarray]:
        """Return the hyperbola on a line: places along it [mm], and along its second axis."""
        hyperbola = self.hyperbola
        if hyperbola is None:
            return np.zeros(0), np.zeros(0)
        across_mm = np.linspace(*line.across_mm, HYPERBOLA_POINTS)
        # With the apex, which may lie between two points.
        across_mm = np.sort(np.append(across_mm, hyperbola.across_mm))
        delays_s = hyperbola.delays_s(across_mm)
        if line.axis is Axis.DELAY_NS:
            return across_mm, delays_s * 1e9
        in_ground_s = delays_s - two_way_delay_s(hyperbola.height_m)
        return across_mm, 1000.0 * one_way_path_m(in_ground_s, self.settings.permittivity)

    def take_permittivity(self) -> None:
        """Use the permittivity of the hyperbola, and move the crosshair to its apex."""
        hyperbola = self.hyperbola
        if hyperbola is not None:
            self.hyperbola = None
            self.change(permittivity=round(hyperbola.permittivity, 1))
            self.set_depth(hyperbola.depth_m)

    def end_hyperbola(self) -> None:
        """Remove the hyperbola."""
        self.hyperbola = None

    def _delay_s(self, second: float, axis: Axis, height_m: float) -> float:
        if axis is Axis.DELAY_NS:
            return second * 1e-9
        permittivity = self.settings.permittivity
        return float(delay_of_depth(second / 1000.0, height_m, permittivity))

    @property
    def _source(self) -> RadarSource:
        if self._image is not None and self.shows_focused:
            return self._image
        return self._echoes
