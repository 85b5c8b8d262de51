"""Random lines over ground with bodies in it: what is buried, and the map of materials.

A line is a cut: a disc is as wide as its diameter, and everything is as long across the line as it
likes. Half of the bodies are level discs of a mine's size, because round targets are what imaging
assumes.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
from line_field import ABSORBING_CELLS, Materials, Windows

CELL_M = 0.0015
STEP_M = 0.012
POSITIONS = 81
SEPARATION_CELLS = 40
# Of the window on both sides of the antennas, above them, and below the surface.
BESIDE_M, ABOVE_M, BELOW_M = 0.40, 0.03, 0.32
HEIGHT_READING_M = 0.0015
AIR, SOIL, METAL, PLASTIC, EMPTY, STONE, ROOT = range(7)


class GroundKind(enum.Enum):
    """What the ground is like."""

    CLEAN = "clean"
    CLUTTERED = "cluttered"
    ROUGH = "rough"
    LOSSY = "lossy"
    ALL = "rough, cluttered and lossy"


class BodyKind(enum.Enum):
    """What is buried."""

    PLASTIC_DISC = "plastic disc"
    METAL_DISC = "metal disc"
    PLASTIC_ROUND = "plastic cylinder"
    METAL_ROUND = "metal cylinder"
    FRAGMENT = "metal fragment"


FLAT = (BodyKind.PLASTIC_DISC, BodyKind.METAL_DISC)


@dataclass(frozen=True)
class Body:
    """One body.

    Attributes:
        kind: What it is.
        x_m: Its middle along the line [m].
        top_m: Depth of its top below the mean surface [m].
        half_width_m: Half its width [m].
        thickness_m: Its thickness; of a cylinder its diameter [m].
    """

    kind: BodyKind
    x_m: float
    top_m: float
    half_width_m: float
    thickness_m: float


@dataclass(frozen=True)
class LineScene:
    """One line and its ground.

    Attributes:
        seed: What it was drawn with.
        ground: What the ground is like.
        permittivity: Relative permittivity of the soil.
        conductivity_s_per_m: Its conductivity [S/m].
        height_m: Height of the antennas above the mean surface [m].
        roughness_m: Standard deviation of the surface [m].
        correlation_m: Its correlation length [m].
        stones: Stones for each metre of the line.
        roots: Roots for each metre of the line.
        bodies: What is buried.
    """

    seed: int
    ground: GroundKind
    permittivity: float
    conductivity_s_per_m: float
    height_m: float
    roughness_m: float
    correlation_m: float
    stones: float
    roots: float
    bodies: Tuple[Body, ...]


@dataclass(frozen=True)
class Painted:
    """A scene as the field needs it.

    Attributes:
        windows: The map, and where the antennas are.
        materials: The materials of the map.
        recorded_height_m: What a height sensor reads at each position [m].
    """

    windows: Windows
    materials: Materials
    recorded_height_m: np.ndarray


def positions_m() -> np.ndarray:
    """Return the positions of the middle of the antennas along the line [m]."""
    return STEP_M * np.arange(POSITIONS)


def draw(seed: int) -> LineScene:
    """Return the scene of a seed; the kinds of ground take turns."""
    random = np.random.default_rng([28, seed])
    kinds = tuple(GroundKind)
    ground = kinds[seed % len(kinds)]
    everything = ground is GroundKind.ALL
    rough = everything or ground is GroundKind.ROUGH
    lossy = everything or ground is GroundKind.LOSSY
    clutter = everything or ground is GroundKind.CLUTTERED
    permittivity = float(random.uniform(3.0, 9.0))
    return LineScene(
        seed,
        ground,
        permittivity,
        float(random.uniform(0.01, 0.05) if lossy else random.uniform(0.0, 0.002)),
        float(random.uniform(0.06, 0.2)),
        float(random.uniform(0.003, 0.010) if rough else random.uniform(0.0, 0.001)),
        float(random.uniform(0.02, 0.08)),
        float(random.uniform(10.0, 40.0)) if clutter else 0.0,
        float(random.uniform(2.0, 8.0)) if clutter else 0.0,
        _bodies(random),
    )


def _bodies(random: np.random.Generator) -> Tuple[Body, ...]:
    found: List[Body] = []
    length_m = STEP_M * (POSITIONS - 1)
    for _ in range(int(random.choice(4, p=(0.2, 0.35, 0.3, 0.15)))):
        kind = tuple(BodyKind)[int(random.choice(5, p=(0.35, 0.2, 0.15, 0.15, 0.15)))]
        half_m = float(random.uniform(0.03, 0.06) if kind in FLAT else random.uniform(0.015, 0.04))
        thick_m = float(random.uniform(0.02, 0.05)) if kind in FLAT else 2.0 * half_m
        if kind is BodyKind.FRAGMENT:
            half_m, thick_m = (
                float(random.uniform(0.003, 0.008)),
                float(random.uniform(0.003, 0.01)),
            )
        top_m = float(random.uniform(0.02, 0.2 - thick_m / 2.0))
        for _ in range(100):
            x_m = float(random.uniform(0.06, length_m - 0.06))
            if all(abs(x_m - one.x_m) > half_m + one.half_width_m + 0.04 for one in found):
                found.append(Body(kind, x_m, top_m, half_m, thick_m))
                break
    return tuple(found)


def paint(scene: LineScene, cell_m: float = CELL_M) -> Painted:
    """Return the map of a scene.

    Args:
        scene: The scene.
        cell_m: Size of its cells [m].
    """
    random = np.random.default_rng([29, scene.seed])
    half = round(BESIDE_M / cell_m) + ABSORBING_CELLS
    antenna_row = round(ABOVE_M / cell_m) + ABSORBING_CELLS
    surface_row = antenna_row + scene.height_m / cell_m
    rows = int(surface_row) + round(BELOW_M / cell_m) + ABSORBING_CELLS
    middle = half + np.rint(positions_m() / cell_m).astype(int)
    columns = int(middle[-1]) + half
    surface_m = _surface(random, columns, cell_m, scene)
    depth_m = (np.arange(rows)[:, None] - surface_row + 0.5) * cell_m
    x_m = (np.arange(columns)[None, :] - half) * cell_m
    soil = depth_m > surface_m
    ground = np.where(soil, SOIL, AIR).astype(np.uint8)
    _clutter(random, ground, soil, x_m, depth_m, scene)
    for body in scene.bodies:
        _bury(ground, x_m, depth_m, body)
    of_clutter = random.uniform(0.0, 1.0, 2)
    stone = scene.permittivity + (1.5 if of_clutter[0] < 0.5 else -1.2)
    materials = Materials(
        np.array([1.0, scene.permittivity, 1.0, 2.8, 1.0, stone, 1.6 * scene.permittivity]),
        np.array([0.0, scene.conductivity_s_per_m, np.inf, 0.0, 0.0, 0.001, 0.02]),
    )
    first = half + SEPARATION_CELLS // 2
    reach = round(0.02 / cell_m)
    below_m = np.array([surface_m[at - reach : at + reach + 1].mean() for at in middle])
    reading_m = HEIGHT_READING_M * random.standard_normal(POSITIONS)
    return Painted(
        Windows(
            ground,
            middle - half,
            2 * half,
            (antenna_row, first - SEPARATION_CELLS),
            (antenna_row, first),
        ),
        materials,
        scene.height_m + below_m + reading_m,
    )


def _surface(
    random: np.random.Generator, columns: int, cell_m: float, scene: LineScene
) -> np.ndarray:
    """Return the depth of the surface below its mean at each column [m]."""
    wave = np.fft.rfftfreq(columns, cell_m) * 2.0 * np.pi
    shape = np.exp(-((wave * scene.correlation_m) ** 2) / 8.0)
    surface = np.fft.irfft(shape * np.fft.rfft(random.standard_normal(columns)), columns)
    surface -= surface.mean()
    found: np.ndarray = scene.roughness_m * surface / max(float(surface.std()), 1e-12)
    return found


def _clutter(
    random: np.random.Generator,
    ground: np.ndarray,
    soil: np.ndarray,
    x_m: np.ndarray,
    depth_m: np.ndarray,
    scene: LineScene,
) -> None:
    length_m, cell_m = float(np.ptp(x_m)), float(x_m[0, 1] - x_m[0, 0])
    for what, density, most_m in ((STONE, scene.stones, 0.018), (ROOT, scene.roots, 0.006)):
        for _ in range(int(random.poisson(density * length_m))):
            at_m = random.uniform(x_m.min(), x_m.max()), random.uniform(0.0, BELOW_M)
            long_m = random.uniform(0.3, 1.0) * most_m
            flat, turn = random.uniform(0.5, 1.0), random.uniform(0.0, np.pi)
            if what == ROOT:
                flat = 1.0
            column, row = (
                int(np.searchsorted(axis, place))
                for axis, place in ((x_m[0], at_m[0]), (depth_m[:, 0], at_m[1]))
            )
            reach = int(long_m / cell_m) + 2
            near = np.s_[max(0, row - reach) : row + reach, max(0, column - reach) : column + reach]
            across, down = x_m[:, near[1]] - at_m[0], depth_m[near[0]] - at_m[1]
            along = across * np.cos(turn) + down * np.sin(turn)
            aside = down * np.cos(turn) - across * np.sin(turn)
            ground[near][(np.hypot(along, aside / flat) < long_m) & soil[near]] = what


def _bury(ground: np.ndarray, x_m: np.ndarray, depth_m: np.ndarray, body: Body) -> None:
    down_m = depth_m - body.top_m
    if body.kind in (*FLAT, BodyKind.FRAGMENT):
        inside = (np.abs(x_m - body.x_m) < body.half_width_m) & (
            np.abs(down_m - body.thickness_m / 2.0) < body.thickness_m / 2.0
        )
    else:
        inside = np.hypot(x_m - body.x_m, down_m - body.half_width_m) < body.half_width_m
    plastic = body.kind in (BodyKind.PLASTIC_DISC, BodyKind.PLASTIC_ROUND)
    ground[inside] = PLASTIC if plastic else METAL
    if body.kind is BodyKind.PLASTIC_DISC:
        # The fuse well: air in the upper third of the middle.
        within = (down_m > body.thickness_m * 0.15) & (down_m < body.thickness_m * 0.4)
        well = (np.abs(x_m - body.x_m) < body.half_width_m / 2.0) & within
        ground[well] = EMPTY
