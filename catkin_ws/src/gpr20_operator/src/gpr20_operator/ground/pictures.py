"""A-, B- and C-scans of the echoes of a survey, as the operator wants to see them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterable, Optional, Tuple, Union

import numpy as np

from gpr20_operator.ground.echoes import ABOVE_SURFACE_M, RadarModel
from gpr20_operator.ground.grid import Cell, Stop
from gpr20_operator.ground.level_scale import LevelScale
from gpr20_operator.ground.records import (
    Axis,
    Curve,
    Picture,
    RadarSettings,
    ascending,
    edges,
)
from gpr20_survey.radar.depth import delay_of_depth, depth_of_delay_m, one_way_path_m
from gpr20_survey.radar.frequency_to_delay import FrequencyToDelay, echoes_at

DEPTH_STEP_M = 0.005
MAX_DEPTH_M = 0.5
# A wave that is drawn with its sign needs so many points per period.
POINTS_PER_PERIOD = 8


def depths_m(
    model: RadarModel, permittivity: float, step_m: float = DEPTH_STEP_M
) -> Optional[np.ndarray]:
    """Return the depths that can be shown [m]; None while no height is known."""
    height_m = model.typical_height_m()
    transform = model.transform
    if transform is None or not np.isfinite(height_m):
        return None
    last_s = (transform.samples - 1) * transform.step_s
    deepest = min(MAX_DEPTH_M, depth_of_delay_m(last_s, height_m, permittivity))
    count = int((deepest + ABOVE_SURFACE_M) / step_m + 1e-6) + 1
    return np.arange(count) * step_m - ABOVE_SURFACE_M


def a_scan(model: RadarModel, cell: Cell, settings: RadarSettings) -> Optional[Curve]:
    """Return the trace of a cell; None if it is not here.

    Its own polarization counts, not that of the settings.
    """
    look = _Look.of(model, settings, cell.polarization)
    if look is None or not model.has(cell):
        return None
    stops = look.stops([cell.stop.row], [cell.stop.column])
    delays_s, places, axis = look.second_axis(stops)
    shades, _above = look.shades(stops, delays_s)
    return Curve(places, shades[0], axis, look.scale, settings.colours.signed)


def b_scan(model: RadarModel, stop: Stop, settings: RadarSettings) -> Optional[Picture]:
    """Return the line through a stop along X or Y; None if nothing was measured yet."""
    look, grid = _Look.of(model, settings, settings.polarization), model.grid
    if look is None or grid is None:
        return None
    rows, columns = grid.shape
    if settings.along is Axis.X_MM:
        stops, across_mm = look.stops([stop.row] * columns, range(columns)), grid.xs_mm
    else:
        stops, across_mm = look.stops(range(rows), [stop.column] * rows), grid.ys_mm
    delays_s, places, axis = look.second_axis(stops)
    shades, above = look.shades(stops, delays_s)
    order, across = ascending(across_mm)
    return Picture(
        shades[order].T,
        across,
        edges(places),
        settings.along,
        axis,
        look.scale,
        above,
        settings.colours.signed,
    )


def c_scan(model: RadarModel, settings: RadarSettings) -> Optional[Picture]:
    """Return the slice at the depth of the settings; None while no height is known."""
    look, grid = _Look.of(model, settings, settings.polarization), model.grid
    if look is None or grid is None or not np.isfinite(model.typical_height_m()):
        return None
    present = np.flatnonzero(model.present(settings.polarization))
    shown, above = look.shades(present, look.depth_delays_s(present, settings.depth_m))
    shades = np.full(grid.shape, np.nan, np.float32)
    shades.flat[present] = shown[:, 0]
    columns, across_mm = ascending(grid.xs_mm)
    rows, range_mm = ascending(grid.ys_mm)
    return Picture(
        shades[rows][:, columns],
        across_mm,
        range_mm,
        Axis.X_MM,
        Axis.Y_MM,
        look.scale,
        above,
        settings.colours.signed,
    )


def level_db(model: RadarModel, stop: Stop, settings: RadarSettings) -> Optional[float]:
    """Return the level at a stop and the depth of the settings, without gain [dB above noise].

    None if nothing is known there.
    """
    look = _Look.of(model, settings, settings.polarization)
    if look is None or not model.has(Cell(stop, settings.polarization)):
        return None
    if not np.isfinite(model.typical_height_m()):
        return None
    stops = look.stops([stop.row], [stop.column])
    echoes = look.echoes(stops, look.depth_delays_s(stops, settings.depth_m))
    level = float(look.scale.levels_db(np.abs(echoes))[0, 0])
    return level if np.isfinite(level) else None


@dataclass(frozen=True)
class _Look:
    """The echoes of one polarization of a model, as the settings show them.

    Stops are numbered row by row.
    """

    model: RadarModel
    settings: RadarSettings
    polarization: int
    transform: FrequencyToDelay
    scale: LevelScale

    @classmethod
    def of(cls, model: RadarModel, settings: RadarSettings, polarization: int) -> Optional[_Look]:
        """Return how a model looks; None before its first trace."""
        scale = model.scale(settings.remove_background, settings.in_db)
        if model.transform is None or scale is None:
            return None
        return cls(model, settings, polarization, model.transform, scale)

    def stops(self, rows: Iterable[int], columns: Iterable[int]) -> np.ndarray:
        """Return the numbers of stops."""
        width = self.model.present(self.polarization).shape[1]
        return np.array([row * width + column for row, column in zip(rows, columns)], np.intp)

    def second_axis(self, stops: np.ndarray) -> Tuple[np.ndarray, np.ndarray, Axis]:
        """Return delays [s] (stops x places), and the places.

        The places are depths [mm], or delays [ns] while no height is known.
        """
        settings = self.settings
        depths = None
        if settings.in_depth:
            depths = depths_m(self.model, settings.permittivity, self._depth_step_m())
        if depths is None:
            delays_s = self._delays_s()
            every = np.broadcast_to(delays_s, (len(stops), len(delays_s)))
            return every, delays_s * 1e9, Axis.DELAY_NS
        return self.depth_delays_s(stops, depths), depths * 1000.0, Axis.DEPTH_MM

    def depth_delays_s(self, stops: np.ndarray, depths: Union[float, np.ndarray]) -> np.ndarray:
        """Return the delays of depths [m] below stops [s] (stops x depths)."""
        heights_m = self.model.heights_m(self.polarization).ravel()[stops, np.newaxis]
        return np.asarray(delay_of_depth(np.asarray(depths), heights_m, self.settings.permittivity))

    def echoes(self, stops: np.ndarray, delays_s: np.ndarray) -> np.ndarray:
        """Return the echoes below stops (stops x delays); NaN where nothing was measured."""
        volume = self.model.echoes(self.polarization)
        step_s = self.transform.step_s
        found = echoes_at(volume.reshape(-1, volume.shape[-1]), stops, step_s, delays_s)
        if self.settings.remove_background:
            background = self.model.background(self.polarization)
            if background is not None:
                first = np.zeros(len(stops), np.intp)
                found -= echoes_at(background[np.newaxis], first, step_s, delays_s)
        found[~self.model.present(self.polarization).ravel()[stops]] = np.nan
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

    def _delays_s(self) -> np.ndarray:
        transform = self.transform
        if not self.settings.colours.signed:
            return transform.delays_s
        finer = max(1, math.ceil(transform.step_s * transform.centre_hz * POINTS_PER_PERIOD))
        return np.arange((transform.samples - 1) * finer + 1) * (transform.step_s / finer)

    def _depth_step_m(self) -> float:
        if not self.settings.colours.signed:
            return DEPTH_STEP_M
        period_s = 1.0 / self.transform.centre_hz
        period_m = one_way_path_m(period_s, self.settings.permittivity)
        return min(DEPTH_STEP_M, period_m / POINTS_PER_PERIOD)
