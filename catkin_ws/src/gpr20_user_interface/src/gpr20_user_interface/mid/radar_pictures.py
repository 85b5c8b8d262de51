"""A-, B- and C-scans of the echoes of a survey, as the operator wants to see them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_user_interface.mid.map_grid import Cell
from gpr20_user_interface.mid.radar_model import RadarModel
from gpr20_user_interface.mid.radar_processing import (
    FrequencyToDelay,
    decibels,
    deepest_m,
    delay_of_depth,
    echoes_at,
    gain_factor,
)

DEPTH_STEP_M = 0.005
# So much above the surface is shown too: its echo shows whether the height is right.
ABOVE_SURFACE_M = 0.05
MAX_DEPTH_M = 0.5


class Axis(enum.Enum):
    """What the second axis of a picture is."""

    DELAY_NS = "delay"
    DEPTH_MM = "depth"
    Y_MM = "y"


@dataclass(frozen=True)
class RadarSettings:
    """What the operator chose.

    Args:
        polarization: Number of the antenna rotation, from 0.
        in_depth: Depth by permittivity instead of delay.
        in_db: Decibels instead of a linear scale.
        remove_background: Take out what all traces of this polarization have in common.
        permittivity: Relative permittivity of the ground.
        gain_db_per_ns: By how much later echoes are shown stronger [dB/ns].
        depth_m: Depth of the slice [m].
    """

    polarization: int = 0
    in_depth: bool = True
    in_db: bool = True
    remove_background: bool = False
    permittivity: float = 4.0
    gain_db_per_ns: float = 0.0
    depth_m: float = 0.05


@dataclass(frozen=True)
class Curve:
    """An A-scan.

    Args:
        places: Delay [ns] or depth [mm].
        levels: Amplitude, linear or in dB.
        axis: What the places are.
    """

    places: np.ndarray
    levels: np.ndarray
    axis: Axis


@dataclass(frozen=True)
class Picture:
    """A B- or C-scan.

    Args:
        levels: Amplitude, linear or in dB, shape (second axis, x); NaN where nothing was measured.
        x_range_mm: Outer edges along X.
        range: Outer edges along the second axis.
        axis: What the second axis is.
    """

    levels: np.ndarray
    x_range_mm: tuple
    range: tuple
    axis: Axis

    @property
    def measured(self) -> bool:
        """Whether there is anything to see."""
        return bool(np.isfinite(self.levels).any())


def depths_m(model: RadarModel, permittivity: float) -> Optional[np.ndarray]:
    """Return the depths that can be shown [m]; None while no height is known."""
    height_m = model.typical_height_m()
    transform = model.transform
    if transform is None or not np.isfinite(height_m):
        return None
    last_s = (transform.samples - 1) * transform.step_s
    deepest = min(MAX_DEPTH_M, deepest_m(last_s, height_m, permittivity))
    return np.arange(-ABOVE_SURFACE_M, deepest + DEPTH_STEP_M / 2, DEPTH_STEP_M)


def a_scan(model: RadarModel, cell: Cell, settings: RadarSettings) -> Optional[Curve]:
    """Return the trace of a cell; None if it is not here.

    Its own polarization counts, not that of the settings.
    """
    transform = model.transform
    if transform is None or not model.has(cell):
        return None
    row, column = cell.stop.row, cell.stop.column
    echoes = model.echoes(cell.polarization)[np.newaxis, row, column]
    height_m = model.heights_m(cell.polarization)[np.newaxis, row, column]
    shown, places, axis = _over_second_axis(
        model, transform, cell.polarization, echoes, height_m, settings
    )
    return Curve(places, _levels(shown[0], settings), axis)


def b_scan(model: RadarModel, row: int, settings: RadarSettings) -> Optional[Picture]:
    """Return the line of a row; None if nothing was measured yet."""
    transform, grid = model.transform, model.grid
    if transform is None or grid is None:
        return None
    polarization = settings.polarization
    shown, places, axis = _over_second_axis(
        model,
        transform,
        polarization,
        model.echoes(polarization)[row],
        model.heights_m(polarization)[row],
        settings,
    )
    levels = _levels(shown, settings)
    levels[~model.present(polarization)[row]] = np.nan
    columns, x_range_mm = _ascending(grid.xs_mm)
    return Picture(levels[columns].T, x_range_mm, _edges(places), axis)


def c_scan(model: RadarModel, settings: RadarSettings) -> Optional[Picture]:
    """Return the slice at the depth of the settings; None while no height is known."""
    transform, grid = model.transform, model.grid
    if transform is None or grid is None or not np.isfinite(model.typical_height_m()):
        return None
    polarization = settings.polarization
    present = model.present(polarization)
    levels = np.full(present.shape, np.nan, np.float32)
    echoes = _without_background(model, polarization, model.echoes(polarization)[present], settings)
    heights_m = model.heights_m(polarization)[present][:, np.newaxis]
    delays_s = np.asarray(delay_of_depth(settings.depth_m, heights_m, settings.permittivity))
    found = echoes_at(echoes, transform.step_s, delays_s)
    gained = found * gain_factor(settings.gain_db_per_ns, delays_s)
    levels[present] = _levels(gained[:, 0], settings)
    columns, x_range_mm = _ascending(grid.xs_mm)
    rows, y_range_mm = _ascending(grid.ys_mm)
    return Picture(levels[rows][:, columns], x_range_mm, y_range_mm, Axis.Y_MM)


def _over_second_axis(
    model: RadarModel,
    transform: FrequencyToDelay,
    polarization: int,
    echoes: np.ndarray,
    heights_m: np.ndarray,
    settings: RadarSettings,
) -> Tuple[np.ndarray, np.ndarray, Axis]:
    """Return echoes (n x places) over depth [mm], or over delay [ns] while no height is known."""
    shown = _without_background(model, polarization, echoes, settings)
    depths = depths_m(model, settings.permittivity) if settings.in_depth else None
    if depths is None:
        delays_s = transform.delays_s
        gained = shown * gain_factor(settings.gain_db_per_ns, delays_s)
        return gained, delays_s * 1e9, Axis.DELAY_NS
    delays_s = np.asarray(
        delay_of_depth(depths[np.newaxis], heights_m[:, np.newaxis], settings.permittivity)
    )
    found = echoes_at(shown, transform.step_s, delays_s)
    gained = found * gain_factor(settings.gain_db_per_ns, delays_s)
    return gained, depths * 1000.0, Axis.DEPTH_MM


def _without_background(
    model: RadarModel, polarization: int, echoes: np.ndarray, settings: RadarSettings
) -> np.ndarray:
    background = model.background(polarization) if settings.remove_background else None
    return echoes if background is None else echoes - background


def _levels(echoes: np.ndarray, settings: RadarSettings) -> np.ndarray:
    level = np.abs(echoes).astype(np.float32)
    return decibels(level) if settings.in_db else level


def _ascending(places_mm: np.ndarray) -> Tuple[slice, Tuple[float, float]]:
    order = slice(None) if places_mm[0] <= places_mm[-1] else slice(None, None, -1)
    return order, _edges(places_mm[order])


def _edges(places: np.ndarray) -> Tuple[float, float]:
    half = abs(places[1] - places[0]) / 2.0
    return float(places[0] - half), float(places[-1] + half)
