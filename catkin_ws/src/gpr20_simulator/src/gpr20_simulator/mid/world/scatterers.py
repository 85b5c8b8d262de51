"""Targets as sets of points that scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence, Tuple

import numpy as np

from gpr20_simulator.mid.world.scene import Shape, Target

# Closer than half a wavelength in any usual soil, so that a row of points acts as one body.
SPACING_M = 0.012


@dataclass(frozen=True)
class Scatterers:
    """All points of all targets, as arrays of equal length.

    Attributes:
        x_m: Place along X [m].
        y_m: Place along Y [m].
        depth_m: Depth below the plane z = 0 [m].
        radius_m: The echo comes from this far before the point [m].
        x_pol_strength: Echo at rotation 0 deg.
        y_pol_strength: Echo at rotation 90 deg.
    """

    x_m: np.ndarray
    y_m: np.ndarray
    depth_m: np.ndarray
    radius_m: np.ndarray
    x_pol_strength: np.ndarray
    y_pol_strength: np.ndarray


def scatterers_of(targets: Sequence[Target]) -> Scatterers:
    """Return the points that stand for the targets; each target's strength is shared."""
    rows: List[Tuple[float, ...]] = []
    for target in targets:
        offsets = _offsets_m(target)
        radius_m = target.size_m / 2.0 if target.shape is Shape.SPHERE else 0.0
        rows += [
            (
                target.x_mm / 1000.0 + x_m,
                target.y_mm / 1000.0 + y_m,
                target.depth_m + radius_m,
                radius_m,
                target.x_pol_strength / len(offsets),
                target.y_pol_strength / len(offsets),
            )
            for x_m, y_m in offsets
        ]
    return Scatterers(*np.array(rows, dtype=np.float64).reshape(-1, 6).T)


def _offsets_m(target: Target) -> List[Tuple[float, float]]:
    """Return where the points lie from the target's centre [m]."""
    if target.shape is Shape.DISC:
        return _disc(target.size_m / 2.0)
    if target.shape is Shape.LINE:
        return _line(target.size_m, math.radians(target.direction_deg))
    return [(0.0, 0.0)]


def _line(length_m: float, direction_rad: float) -> List[Tuple[float, float]]:
    count = max(2, math.ceil(length_m / SPACING_M) + 1)
    along_m = np.linspace(-length_m / 2.0, length_m / 2.0, count)
    return [(a * math.cos(direction_rad), a * math.sin(direction_rad)) for a in along_m]


def _disc(radius_m: float) -> List[Tuple[float, float]]:
    # Ring k of n holds 6 k points, which covers the disc evenly.
    rings = max(1, math.ceil(radius_m / SPACING_M))
    points = [(0.0, 0.0)]
    for ring in range(1, rings + 1):
        for place in range(6 * ring):
            angle_rad = 2.0 * math.pi * place / (6 * ring)
            ring_m = radius_m * ring / rings
            points.append((ring_m * math.cos(angle_rad), ring_m * math.sin(angle_rad)))
    return points
