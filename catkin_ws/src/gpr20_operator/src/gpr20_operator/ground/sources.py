"""Pictures of the ground and their sources: the echoes of a survey, or its focused image.

Both sources return None while there is nothing to show.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Optional, Tuple, Union

import numpy as np

from gpr20_operator.ground.echoes import ABOVE_SURFACE_M, LevelScale, RadarModel
from gpr20_operator.ground.grid import Place, ascending
from gpr20_survey.radar import delay_of_depth, depth_of_delay_m
from gpr20_survey.results.answers import FocusedImage

DEPTH_STEP_M = 0.005
MAX_DEPTH_M = 0.5


class Axis(enum.Enum):
    """What the axis of a picture is."""

    DEPTH_MM = "depth"
    X_MM = "x"
    Y_MM = "y"


class Layer(enum.Enum):
    """What is drawn of the ground from above, besides candidates and markers."""

    COVERAGE = "coverage"
    ECHOES = "echoes"
    FOCUSED = "focused"
    HIDING = "hiding"
    """The echoes, hatched where a mine could hide."""


@dataclass(frozen=True)
class RadarSettings:
    """What the operator chose.

    Args:
        polarization: Number of the antenna rotation, from 0.
        permittivity: Relative permittivity of the ground.
        depth_m: Depth of the slice and of the crosshair [m].
        along: Axis that the section is parallel to: X or Y.
        layer: What is drawn from above.
    """

    polarization: int = 0
    permittivity: float = 4.0
    depth_m: float = 0.05
    along: Axis = Axis.X_MM
    layer: Layer = Layer.ECHOES


@dataclass(frozen=True)
class Picture:
    """A section (B-scan) or a slice (C-scan).

    Args:
        levels_db: Levels [dB above noise], shape (second axis, across); NaN where nothing was
            measured.
        across_mm: Outer edges along the first axis [mm].
        range: Outer edges along the second axis.
        axis: What the second axis is.
        scale: The scale of the survey.
    """

    levels_db: np.ndarray
    across_mm: Tuple[float, float]
    range: Tuple[float, float]
    axis: Axis
    scale: LevelScale

    @property
    def shades(self) -> np.ndarray:
        """The place of each level in the scale, from 0 to 1."""
        return self.scale.shades(self.levels_db)

    @property
    def measured(self) -> bool:
        """Whether there is anything to see."""
        return bool(np.isfinite(self.levels_db).any())

    @property
    def above_noise(self) -> bool:
        """Whether any level is above all noise."""
        return bool((self.levels_db > self.scale.threshold_db).any())

    def level_db(self, across_mm: float, second: float) -> Optional[float]:
        """Return the level of the cell at a place [dB above noise]; None: not measured."""
        cell = []
        for at, (first, last), count in zip(
            (second, across_mm), (self.range, self.across_mm), self.levels_db.shape
        ):
            part = (at - first) / (last - first)
            cell.append(min(max(int(part * count), 0), count - 1))
        level = float(self.levels_db[tuple(cell)])
        return level if np.isfinite(level) else None


def _picture(
    levels_db: np.ndarray,
    across_mm: np.ndarray,
    second: np.ndarray,
    axis: Axis,
    scale: LevelScale,
) -> Picture:
    """Return the picture of levels at places (second axis, across), in their order."""
    (columns, across), (rows, edges_of_rows) = ascending(across_mm), ascending(second)
    return Picture(levels_db[rows, columns], across, edges_of_rows, axis, scale)


class EchoSource:
    """The echoes as they were measured, of the polarization of the settings."""

    def __init__(self, model: RadarModel) -> None:
        self._model = model

    def nearest(self, place: Place) -> Optional[Place]:
        grid = self._model.grid
        return None if grid is None else grid.place_of(grid.closest_stop(*place))

    def deepest_m(self, settings: RadarSettings) -> Optional[float]:
        """Return the depth of the last delay [m]; None while no height is known."""
        depths = self.depths_m(settings)
        return None if depths is None else float(depths[-1])

    def depths_m(self, settings: RadarSettings) -> Optional[np.ndarray]:
        """Return the depths that can be shown [m]; None while no height is known."""
        height_m, transform = self._model.typical_height_m(), self._model.transform
        if transform is None or not np.isfinite(height_m):
            return None
        last_s = (transform.samples - 1) * transform.step_s
        deepest = min(MAX_DEPTH_M, depth_of_delay_m(last_s, height_m, settings.permittivity))
        count = int((deepest + ABOVE_SURFACE_M) / DEPTH_STEP_M + 1e-6) + 1
        return np.arange(count) * DEPTH_STEP_M - ABOVE_SURFACE_M

    def section(self, place: Place, settings: RadarSettings) -> Optional[Picture]:
        """Return the section through the nearest stop; None while no height is known."""
        grid, scale, depths = self._model.grid, self._model.scale(), self.depths_m(settings)
        if grid is None or scale is None or depths is None:
            return None
        row, column = grid.closest_stop(*place)
        along_x = settings.along is Axis.X_MM
        stops = (row, slice(None)) if along_x else (slice(None), column)
        delays_s = self._delays_s(stops, depths, settings)
        levels_db = self._levels_db(stops, delays_s, settings, scale)
        across_mm = grid.xs_mm if along_x else grid.ys_mm
        return _picture(levels_db.T, across_mm, depths * 1000.0, Axis.DEPTH_MM, scale)

    def slice(self, settings: RadarSettings) -> Optional[Picture]:
        """Return the slice at the depth of the settings."""
        grid, scale = self._model.grid, self._model.scale()
        if grid is None or scale is None or not np.isfinite(self._model.typical_height_m()):
            return None
        stops = (slice(None), slice(None))
        delays_s = self._delays_s(stops, settings.depth_m, settings)
        levels_db = self._levels_db(stops, delays_s, settings, scale).reshape(grid.shape)
        return _picture(levels_db, grid.xs_mm, grid.ys_mm, Axis.Y_MM, scale)

    def _delays_s(self, stops: Any, depths_m: Any, settings: RadarSettings) -> np.ndarray:
        """Return the delays of depths [m] below stops [s] (stops x depths)."""
        heights_m = self._model.heights_m(settings.polarization)[stops].reshape(-1, 1)
        return np.asarray(delay_of_depth(np.asarray(depths_m), heights_m, settings.permittivity))

    def _levels_db(
        self, stops: Any, delays_s: np.ndarray, settings: RadarSettings, scale: LevelScale
    ) -> np.ndarray:
        """Return the levels below stops (stops x delays); NaN where nothing was measured.

        Stops are rows and columns as numpy takes them; delays are for each, or the same for all.
        """
        model, number = self._model, settings.polarization
        present, echoes = model.present[number][stops], model.echoes[number][stops]
        echoes = echoes.reshape(-1, echoes.shape[-1])
        place = delays_s / (1.0 if model.transform is None else model.transform.step_s)
        last = echoes.shape[1] - 1
        below = np.clip(np.floor(place), 0, last - 1).astype(np.intp)
        part = (place - below).astype(np.float32)
        row = np.arange(len(echoes))[:, np.newaxis]
        found = echoes[row, below] * (1.0 - part) + echoes[row, below + 1] * part
        background = model.background(number)
        if background is not None:
            found -= background[below] * (1.0 - part) + background[below + 1] * part
        # Nothing is known between the stops, nor before the first delay and after the last one.
        found[~(np.reshape(present, (-1, 1)) & (place >= 0.0) & (place <= last))] = np.nan
        return scale.levels_db(np.abs(found))


class FocusedSource:
    """A focused image; its levels are above the noise already.

    Polarization and permittivity were chosen when it was made.

    Args:
        image: The image.
        before: The source before: of the same survey, its scale is continued.
    """

    def __init__(self, image: FocusedImage, before: Optional[FocusedSource] = None) -> None:
        self.image = image
        if before is not None and before.image.found.survey_id != image.found.survey_id:
            before = None
        known = image.levels_db[np.isfinite(image.levels_db)]
        strongest = 10.0 ** (float(known.max()) / 20.0) if known.size else 1.0
        last = None if before is None else before._scale
        self._scale: LevelScale = LevelScale.of(image.levels_db.size, 1.0, strongest, last)

    def nearest(self, place: Place) -> Optional[Place]:
        row, column = self._index(place)
        return Place(float(self.image.x_mm[column]), float(self.image.y_mm[row]))

    def deepest_m(self, _settings: RadarSettings) -> Optional[float]:
        """Return the depth of the last layer [m]."""
        return float(self.image.depth_mm[-1]) / 1000.0

    def section(self, place: Place, settings: RadarSettings) -> Optional[Picture]:
        """Return the section through a place."""
        image, (row, column) = self.image, self._index(place)
        along_x = settings.along is Axis.X_MM
        levels_db = image.levels_db[:, row] if along_x else image.levels_db[:, :, column]
        across_mm = image.x_mm if along_x else image.y_mm
        return _picture(levels_db, across_mm, image.depth_mm, Axis.DEPTH_MM, self._scale)

    def slice(self, settings: RadarSettings) -> Optional[Picture]:
        """Return the layer nearest to the depth of the settings."""
        layer = int(np.argmin(np.abs(self.image.depth_mm - settings.depth_m * 1000.0)))
        return self._above(self.image.levels_db[layer])

    def from_above(self) -> Picture:
        """Return the largest level of all depths at each place."""
        return self._above(np.fmax.reduce(self.image.levels_db, axis=0))

    def _index(self, place: Place) -> Tuple[int, int]:
        row = int(np.argmin(np.abs(self.image.y_mm - place.y_mm)))
        return row, int(np.argmin(np.abs(self.image.x_mm - place.x_mm)))

    def _above(self, levels_db: np.ndarray) -> Picture:
        return _picture(levels_db, self.image.x_mm, self.image.y_mm, Axis.Y_MM, self._scale)


RadarSource = Union[EchoSource, FocusedSource]
