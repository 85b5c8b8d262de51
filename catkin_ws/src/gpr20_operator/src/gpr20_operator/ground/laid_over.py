"""The focused image of a survey with those of finer surveys laid over it."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import numpy as np

from gpr20_survey.results.focused_image import FocusedImage

# 48 MB; an image beyond that keeps its own spacing.
MOST_VOXELS = 12_000_000
MOST_PARTS = 6


def laid_over(coarse: FocusedImage, finer: Sequence[FocusedImage]) -> FocusedImage:
    """Return an image that has the levels of finer images where these lie.

    Each cell of the coarse image is divided into as many as the closest spacing needs. Nothing is
    interpolated: a cell has the level of one voxel of one image, of the last one on top.
    """
    for one in finer:
        coarse = _with(coarse, one)
    return coarse


def _with(coarse: FocusedImage, fine: FocusedImage) -> FocusedImage:
    if min(map(len, (coarse.x_mm, coarse.y_mm, fine.x_mm, fine.y_mm))) < 2:
        return coarse
    x_parts = _parts(coarse.x_mm, fine.x_mm)
    y_parts = _parts(coarse.y_mm, fine.y_mm)
    while coarse.levels_db.size * x_parts * y_parts > MOST_VOXELS and max(x_parts, y_parts) > 1:
        x_parts, y_parts = max(1, x_parts - 1), max(1, y_parts - 1)
    x_mm, y_mm = _divided(coarse.x_mm, x_parts), _divided(coarse.y_mm, y_parts)
    levels_db = coarse.levels_db.repeat(y_parts, axis=1).repeat(x_parts, axis=2)
    columns, rows = _inside(x_mm, fine.x_mm), _inside(y_mm, fine.y_mm)
    if not (columns.size and rows.size):
        return coarse
    nearest = np.ix_(
        _nearest(coarse.depth_mm, fine.depth_mm),
        _nearest(y_mm[rows], fine.y_mm),
        _nearest(x_mm[columns], fine.x_mm),
    )
    part, covered = fine.levels_db[nearest], np.ix_(np.arange(len(levels_db)), rows, columns)
    # Where the finer survey measured nothing, the coarse one stays.
    levels_db[covered] = np.where(np.isfinite(part), part, levels_db[covered])
    return replace(coarse, x_mm=x_mm, y_mm=y_mm, levels_db=levels_db)


def _spacing(places_mm: np.ndarray) -> float:
    return float(abs(places_mm[1] - places_mm[0]))


def _parts(coarse_mm: np.ndarray, fine_mm: np.ndarray) -> int:
    ratio = _spacing(coarse_mm) / max(_spacing(fine_mm), 1e-9)
    return int(min(max(round(ratio), 1), MOST_PARTS))


def _divided(places_mm: np.ndarray, parts: int) -> np.ndarray:
    spacing_mm = (places_mm[1] - places_mm[0]) / parts
    offsets_mm = (np.arange(parts) - (parts - 1) / 2.0) * spacing_mm
    return (places_mm[:, None] + offsets_mm).ravel()


def _inside(places_mm: np.ndarray, fine_mm: np.ndarray) -> np.ndarray:
    """Return which places lie in the area of a finer image (whole numbers)."""
    half_mm = _spacing(fine_mm) / 2.0
    low_mm, high_mm = fine_mm.min() - half_mm, fine_mm.max() + half_mm
    return np.flatnonzero((places_mm >= low_mm) & (places_mm <= high_mm))


def _nearest(places_mm: np.ndarray, among_mm: np.ndarray) -> np.ndarray:
    """Return the index of the nearest of some places for each place."""
    return np.abs(places_mm[:, None] - among_mm).argmin(axis=1)
