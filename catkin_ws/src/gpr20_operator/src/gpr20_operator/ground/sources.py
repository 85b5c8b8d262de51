"""What pictures are made of: the echoes of the survey, or its focused image."""

from __future__ import annotations

from typing import Optional, Tuple, Union

import numpy as np

from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import Cell, Stop
from gpr20_operator.ground.level_scale import LevelScale, SteadyScale
from gpr20_operator.ground.pictures import a_scan, b_scan, c_scan, depths_m, level_db
from gpr20_operator.ground.records import (
    Axis,
    Curve,
    Picture,
    Place,
    RadarSettings,
    ascending,
    edges,
)
from gpr20_survey.results.focused_image import FocusedImage


class EchoSource:
    """The echoes as they were measured."""

    def __init__(self, model: RadarModel) -> None:
        self._model = model

    def stop(self, place: Place) -> Optional[Stop]:
        """Return the stop nearest to a place, also from outside of the area."""
        grid = self._model.grid
        return None if grid is None else grid.closest_stop(place.x_mm, place.y_mm)

    def nearest(self, place: Place) -> Optional[Place]:
        """Return the place of the nearest stop."""
        stop, grid = self.stop(place), self._model.grid
        if stop is None or grid is None:
            return None
        return Place(float(grid.xs_mm[stop.column]), float(grid.ys_mm[stop.row]))

    def deepest_m(self, settings: RadarSettings) -> Optional[float]:
        """Return the depth of the last delay [m]; None while no height is known."""
        depths = depths_m(self._model, settings.permittivity)
        return None if depths is None else float(depths[-1])

    def curve(self, place: Place, settings: RadarSettings) -> Optional[Curve]:
        """Return the trace of the nearest stop."""
        stop = self.stop(place)
        if stop is None:
            return None
        return a_scan(self._model, Cell(stop, settings.polarization), settings)

    def line(self, place: Place, settings: RadarSettings) -> Optional[Picture]:
        """Return the line through the nearest stop."""
        stop = self.stop(place)
        return None if stop is None else b_scan(self._model, stop, settings)

    def slice(self, settings: RadarSettings) -> Optional[Picture]:
        """Return the slice at the depth of the settings."""
        return c_scan(self._model, settings)

    def level_db(self, place: Place, settings: RadarSettings) -> Optional[float]:
        """Return the level at the nearest stop [dB above noise]."""
        stop = self.stop(place)
        return None if stop is None else level_db(self._model, stop, settings)


class FocusedSource:
    """A focused image; its levels are above the noise already.

    Polarization, background, gain and permittivity were chosen when it was made. It has no sign.

    Args:
        image: The image.
        steady: The scale of earlier images of the same survey, which this one continues.
    """

    def __init__(self, image: FocusedImage, steady: Optional[SteadyScale] = None) -> None:
        self.image = image
        self.steady = steady or SteadyScale(image.levels_db.size)
        known = image.levels_db[np.isfinite(image.levels_db)]
        strongest_db = float(known.max()) if known.size else 0.0
        self.steady.update(1.0, 10.0 ** (strongest_db / 20.0))

    def nearest(self, place: Place) -> Optional[Place]:
        """Return the place of the nearest column of the image."""
        image = self.image
        row, column = self._index(place)
        return Place(float(image.x_mm[column]), float(image.y_mm[row]))

    def deepest_m(self, settings: RadarSettings) -> Optional[float]:
        """Return the depth of the last layer [m]."""
        return float(self.image.depth_mm[-1]) / 1000.0

    def curve(self, place: Place, settings: RadarSettings) -> Optional[Curve]:
        """Return the column below a place."""
        row, column = self._index(place)
        levels_db = self.image.levels_db[:, row, column]
        if not np.isfinite(levels_db).any():
            return None
        scale = self._scale(settings)
        return Curve(self.image.depth_mm, _shades(scale, levels_db), Axis.DEPTH_MM, scale)

    def line(self, place: Place, settings: RadarSettings) -> Optional[Picture]:
        """Return the line through a place."""
        image = self.image
        row, column = self._index(place)
        if settings.along is Axis.X_MM:
            levels_db, across_mm = image.levels_db[:, row], image.x_mm
        else:
            levels_db, across_mm = image.levels_db[:, :, column], image.y_mm
        return self._picture(levels_db, across_mm, settings.along, image.depth_mm, settings)

    def slice(self, settings: RadarSettings) -> Optional[Picture]:
        """Return the layer nearest to the depth of the settings."""
        image = self.image
        layer = image.levels_db[self._layer(settings)]
        return self._picture(layer, image.x_mm, Axis.X_MM, image.y_mm, settings)

    def from_above(self) -> Picture:
        """Return the largest level of all depths at each place."""
        image = self.image
        levels_db = np.fmax.reduce(image.levels_db, axis=0)
        return self._picture(levels_db, image.x_mm, Axis.X_MM, image.y_mm, RadarSettings())

    def level_db(self, place: Place, settings: RadarSettings) -> Optional[float]:
        """Return the level of a voxel [dB above noise]."""
        row, column = self._index(place)
        level = float(self.image.levels_db[self._layer(settings), row, column])
        return level if np.isfinite(level) else None

    def _index(self, place: Place) -> Tuple[int, int]:
        row = int(np.argmin(np.abs(self.image.y_mm - place.y_mm)))
        return row, int(np.argmin(np.abs(self.image.x_mm - place.x_mm)))

    def _layer(self, settings: RadarSettings) -> int:
        return int(np.argmin(np.abs(self.image.depth_mm - settings.depth_m * 1000.0)))

    def _scale(self, settings: RadarSettings) -> LevelScale:
        return self.steady.scale(settings.in_db)

    def _picture(
        self,
        levels_db: np.ndarray,
        across_mm: np.ndarray,
        across: Axis,
        second_mm: np.ndarray,
        settings: RadarSettings,
    ) -> Picture:
        scale = self._scale(settings)
        order, across_edges = ascending(across_mm)
        above = bool((levels_db > scale.threshold_db).any())
        return Picture(
            _shades(scale, levels_db)[:, order],
            across_edges,
            edges(second_mm),
            across,
            Axis.Y_MM if second_mm is self.image.y_mm else Axis.DEPTH_MM,
            scale,
            above,
        )


def _shades(scale: LevelScale, levels_db: np.ndarray) -> np.ndarray:
    return scale.shades(levels_db, np.zeros(1, np.float32))


# Both return None while there is nothing to show.
RadarSource = Union[EchoSource, FocusedSource]
