"""What pictures are made of: the echoes of a survey, or its focused image.

Both sources return None while there is nothing to show.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple, Union

import numpy as np

from gpr20_operator.ground.echoes import ABOVE_SURFACE_M, RadarModel
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_operator.ground.level_scale import LevelScale, SteadyScale
from gpr20_operator.ground.records import (
    Axis,
    Curve,
    Picture,
    Place,
    RadarSettings,
    ascending,
    edges,
)
from gpr20_survey.radar.depth import delay_of_depth, depth_of_delay_m, one_way_path_m
from gpr20_survey.radar.frequency_to_delay import FrequencyToDelay
from gpr20_survey.results.focused_image import FocusedImage

DEPTH_STEP_M = 0.005
MAX_DEPTH_M = 0.5
# A wave that is drawn with its sign needs so many points per period.
POINTS_PER_PERIOD = 8


def depths_m(
    model: RadarModel, permittivity: float, step_m: float = DEPTH_STEP_M
) -> Optional[np.ndarray]:
    """Return the depths that can be shown [m]; None while no height is known."""
    height_m, transform = model.typical_height_m(), model.transform
    if transform is None or not np.isfinite(height_m):
        return None
    last_s = (transform.samples - 1) * transform.step_s
    deepest = min(MAX_DEPTH_M, depth_of_delay_m(last_s, height_m, permittivity))
    count = int((deepest + ABOVE_SURFACE_M) / step_m + 1e-6) + 1
    return np.arange(count) * step_m - ABOVE_SURFACE_M


class EchoSource:
    """The echoes as they were measured, of the polarization of the settings."""

    def __init__(self, model: RadarModel) -> None:
        self._model = model

    def nearest(self, place: Place) -> Optional[Place]:
        grid = self._model.grid
        return None if grid is None else grid.place_of(grid.closest_stop(place.x_mm, place.y_mm))

    def deepest_m(self, settings: RadarSettings) -> Optional[float]:
        """Return the depth of the last delay [m]; None while no height is known."""
        depths = depths_m(self._model, settings.permittivity)
        return None if depths is None else float(depths[-1])

    def curve(self, place: Place, settings: RadarSettings) -> Optional[Curve]:
        """Return the trace of the nearest stop (A-scan)."""
        look = _Look.of(self._model, settings)
        if look is None or not look.present[look.stops(place)]:
            return None
        stops = look.stops(place)
        delays_s, places, axis = look.second_axis(stops)
        shades, _above = look.shades(stops, delays_s)
        return Curve(places, shades[0], axis, look.scale, settings.colours.signed)

    def line(self, place: Place, settings: RadarSettings) -> Optional[Picture]:
        """Return the line through the nearest stop (B-scan)."""
        look = _Look.of(self._model, settings)
        if look is None:
            return None
        stops = look.stops(place, settings.along)
        delays_s, places, axis = look.second_axis(stops)
        shades, above = look.shades(stops, delays_s)
        along_x = settings.along is Axis.X_MM
        order, across = ascending(look.grid.xs_mm if along_x else look.grid.ys_mm)
        signed = settings.colours.signed
        return Picture(shades[order].T, across, edges(places), axis, look.scale, above, signed)

    def slice(self, settings: RadarSettings) -> Optional[Picture]:
        """Return the slice at the depth of the settings (C-scan)."""
        look = _Look.of(self._model, settings)
        if look is None or not np.isfinite(self._model.typical_height_m()):
            return None
        grid, present = look.grid, np.flatnonzero(look.present)
        shown, above = look.shades(present, look.depth_delays_s(present, settings.depth_m))
        shades = np.full(grid.shape, np.nan, np.float32)
        shades.flat[present] = shown[:, 0]
        (_columns, across_mm), (_rows, range_mm) = ascending(grid.xs_mm), ascending(grid.ys_mm)
        return Picture(
            *(shades[grid.ascending], across_mm, range_mm, Axis.Y_MM, look.scale, above),
            signed=settings.colours.signed,
        )

    def level_db(self, place: Place, settings: RadarSettings) -> Optional[float]:
        """Return the level at the nearest stop and the depth, without gain [dB above noise]."""
        look = _Look.of(self._model, settings)
        if look is None or not np.isfinite(self._model.typical_height_m()):
            return None
        stops = look.stops(place)
        # NaN where no trace is.
        echoes = look.echoes(stops, look.depth_delays_s(stops, settings.depth_m))
        level = float(look.scale.levels_db(np.abs(echoes))[0, 0])
        return level if np.isfinite(level) else None


@dataclass(frozen=True)
class _Look:
    """The echoes of a model as the settings show them; stops are numbered row by row."""

    model: RadarModel
    settings: RadarSettings
    grid: SurveyGrid
    transform: FrequencyToDelay
    scale: LevelScale

    @classmethod
    def of(cls, model: RadarModel, settings: RadarSettings) -> Optional[_Look]:
        """Return how a model looks; None before its first trace."""
        scale = model.scale(settings.remove_background, settings.in_db)
        if model.grid is None or model.transform is None or scale is None:
            return None
        return cls(model, settings, model.grid, model.transform, scale)

    @property
    def present(self) -> np.ndarray:
        """Which stops have a trace (bool)."""
        return self.model.present[self.settings.polarization].ravel()

    def stops(self, place: Place, along: Optional[Axis] = None) -> np.ndarray:
        """Return the stop nearest to a place, or the line along an axis through it."""
        stop = self.grid.closest_stop(place.x_mm, place.y_mm)
        rows, columns = self.grid.shape
        if along is None:
            return np.array([stop.row * columns + stop.column])
        if along is Axis.X_MM:
            return stop.row * columns + np.arange(columns)
        return np.arange(rows) * columns + stop.column

    def second_axis(self, stops: np.ndarray) -> Tuple[np.ndarray, np.ndarray, Axis]:
        """Return delays [s] (stops x places), and the places.

        The places are depths [mm], or delays [ns] while no height is known.
        """
        transform, permittivity = self.transform, self.settings.permittivity
        signed, depths = self.settings.colours.signed, None
        if self.settings.in_depth:
            period_m = one_way_path_m(1.0 / transform.centre_hz, permittivity)
            step_m = min(DEPTH_STEP_M, period_m / POINTS_PER_PERIOD) if signed else DEPTH_STEP_M
            depths = depths_m(self.model, permittivity, step_m)
        if depths is not None:
            return self.depth_delays_s(stops, depths), depths * 1000.0, Axis.DEPTH_MM
        delays_s = transform.delays_s
        if signed:
            finer = max(1, math.ceil(transform.step_s * transform.centre_hz * POINTS_PER_PERIOD))
            delays_s = np.arange((transform.samples - 1) * finer + 1) * (transform.step_s / finer)
        every = np.broadcast_to(delays_s, (len(stops), len(delays_s)))
        return every, delays_s * 1e9, Axis.DELAY_NS

    def depth_delays_s(self, stops: np.ndarray, depths: Union[float, np.ndarray]) -> np.ndarray:
        """Return the delays of depths [m] below stops [s] (stops x depths)."""
        heights_m = self.model.heights_m(self.settings.polarization).ravel()[stops, np.newaxis]
        return np.asarray(delay_of_depth(np.asarray(depths), heights_m, self.settings.permittivity))

    def echoes(self, stops: np.ndarray, delays_s: np.ndarray) -> np.ndarray:
        """Return the echoes below stops (stops x delays); NaN where nothing was measured."""
        volume = self.model.echoes[self.settings.polarization]
        step_s = self.transform.step_s
        found = _echoes_at(volume.reshape(-1, volume.shape[-1]), stops, step_s, delays_s)
        if self.settings.remove_background:
            background = self.model.background(self.settings.polarization)
            if background is not None:
                first = np.zeros(len(stops), np.intp)
                found -= _echoes_at(background[np.newaxis], first, step_s, delays_s)
        found[~self.present[stops]] = np.nan
        return found

    def shades(self, stops: np.ndarray, delays_s: np.ndarray) -> Tuple[np.ndarray, bool]:
        """Return the shades of the echoes, and whether any of them is above all noise."""
        echoes, scale = self.echoes(stops, delays_s), self.scale
        levels_db = scale.levels_db(np.abs(echoes))
        above = bool((levels_db > scale.threshold_db).any())
        gain_db = self.settings.gain_db_per_ns * 1e9 * delays_s
        if not self.settings.colours.signed:
            return scale.shades(levels_db, gain_db), above
        wave = (echoes * self.transform.carrier(delays_s)).real
        return np.sign(wave) * scale.shades(scale.levels_db(np.abs(wave)), gain_db), above


def _echoes_at(
    echoes: np.ndarray, rows: np.ndarray, step_s: float, delays_s: np.ndarray
) -> np.ndarray:
    """Return echoes between the samples by linear interpolation; NaN outside of them.

    Args:
        echoes: Complex samples, shape (n, samples).
        rows: Which of them, shape (m,).
        step_s: Delay between two samples [s].
        delays_s: Delays of the result, shape (m, k) [s].
    """
    place = delays_s / step_s
    last = echoes.shape[1] - 1
    below = np.clip(np.floor(place), 0, last - 1).astype(np.intp)
    part = (place - below).astype(np.float32)
    of_row = rows[:, np.newaxis]
    values = echoes[of_row, below] * (1.0 - part) + echoes[of_row, below + 1] * part
    values[~((place >= 0.0) & (place <= last))] = np.nan
    return values


class FocusedSource:
    """A focused image; its levels are above the noise already.

    Polarization, background, gain and permittivity were chosen when it was made. It has no sign.

    Args:
        image: The image.
        before: The source before: of the same survey, its scale is continued.
    """

    def __init__(self, image: FocusedImage, before: Optional[FocusedSource] = None) -> None:
        self.image = image
        self._steady = SteadyScale(image.levels_db.size)
        if before is not None and before.image.found.survey_id == image.found.survey_id:
            self._steady = before._steady
        known = image.levels_db[np.isfinite(image.levels_db)]
        strongest_db = float(known.max()) if known.size else 0.0
        self._steady.update(1.0, 10.0 ** (strongest_db / 20.0))

    def nearest(self, place: Place) -> Optional[Place]:
        row, column = self._index(place)
        return Place(float(self.image.x_mm[column]), float(self.image.y_mm[row]))

    def deepest_m(self, _settings: RadarSettings) -> Optional[float]:
        """Return the depth of the last layer [m]."""
        return float(self.image.depth_mm[-1]) / 1000.0

    def curve(self, place: Place, settings: RadarSettings) -> Optional[Curve]:
        """Return the column below a place."""
        row, column = self._index(place)
        levels_db = self.image.levels_db[:, row, column]
        if not np.isfinite(levels_db).any():
            return None
        scale = self._steady.scale(settings.in_db)
        return Curve(self.image.depth_mm, scale.shades(levels_db), Axis.DEPTH_MM, scale)

    def line(self, place: Place, settings: RadarSettings) -> Optional[Picture]:
        """Return the line through a place."""
        image, (row, column) = self.image, self._index(place)
        if settings.along is Axis.X_MM:
            return self._picture(image.levels_db[:, row], image.x_mm, Axis.DEPTH_MM, settings)
        return self._picture(image.levels_db[:, :, column], image.y_mm, Axis.DEPTH_MM, settings)

    def slice(self, settings: RadarSettings) -> Optional[Picture]:
        """Return the layer nearest to the depth of the settings."""
        layer = self.image.levels_db[self._layer(settings)]
        return self._picture(layer, self.image.x_mm, Axis.Y_MM, settings)

    def from_above(self) -> Picture:
        """Return the largest level of all depths at each place."""
        levels_db = np.fmax.reduce(self.image.levels_db, axis=0)
        return self._picture(levels_db, self.image.x_mm, Axis.Y_MM, RadarSettings())

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

    def _picture(
        self, levels_db: np.ndarray, across_mm: np.ndarray, axis: Axis, settings: RadarSettings
    ) -> Picture:
        scale = self._steady.scale(settings.in_db)
        order, across = ascending(across_mm)
        second = edges(self.image.y_mm if axis is Axis.Y_MM else self.image.depth_mm)
        above = bool((levels_db > scale.threshold_db).any())
        return Picture(scale.shades(levels_db)[:, order], across, second, axis, scale, above)


RadarSource = Union[EchoSource, FocusedSource]
