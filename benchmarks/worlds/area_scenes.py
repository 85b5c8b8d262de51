"""Areas over ground with bodies in it: the five laboratory scenes of Uniandes, and random ones.

The truth of the five is that of the tables of "Mediciones Machine Learning" (GPR-Uniandes, March
2022), which contradict that document's own tables of observations for scenes 3, 4 and 5. Here the
scenes are computed, so what the first tables say is what is there. Not stated there, and assumed:
mines 70 mm high and of relative permittivity 2.8, plates 10 mm thick, antennas 60 mm apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
from area_field import ABSORBING_CELLS, Boxes
from line_field import Materials

AIR, SOIL, METAL, PLASTIC = range(4)
SEPARATION_M = 0.06


@dataclass(frozen=True)
class Block:
    """One body.

    Attributes:
        name: What it is.
        is_metal: Whether it conducts; otherwise it is plastic.
        is_sphere: Whether it is a sphere; otherwise it is level at top and bottom.
        x_m: Its middle along X [m].
        y_m: Its middle along Y [m].
        top_m: Depth of its top [m].
        size_m: Its extent along X and Y [m]; of a sphere or an upright cylinder its diameter.
        height_m: Its height [m].
        is_round: Whether it is round seen from above.
    """

    name: str
    is_metal: bool
    is_sphere: bool
    x_m: float
    y_m: float
    top_m: float
    size_m: Tuple[float, float]
    height_m: float
    is_round: bool = True


@dataclass(frozen=True)
class AreaScene:
    """One area and its ground.

    Attributes:
        name: Its name.
        permittivity: Relative permittivity of the soil.
        conductivity_s_per_m: Its conductivity [S/m].
        height_m: Height of the antennas [m].
        step_m: Distance of the positions [m].
        positions: Positions along X, and along Y.
        cell_m: Size of the cells [m].
        last_hz: Last frequency; the first is 600 MHz.
        record_s: Length of the record [s].
        beside_m: Ground beside the antennas that is computed [m].
        below_m: Ground below the surface that is computed [m].
        bodies: What is buried.
    """

    name: str
    permittivity: float
    conductivity_s_per_m: float
    height_m: float
    step_m: float
    positions: int
    cell_m: float
    last_hz: float
    record_s: float
    beside_m: float
    below_m: float
    bodies: Tuple[Block, ...]


def _sphere(x_mm: float, y_mm: float, top_mm: float) -> Block:
    return Block("sphere", True, True, x_mm / 1e3, y_mm / 1e3, top_mm / 1e3, (0.07, 0.07), 0.07)


def _plate(x_mm: float, y_mm: float, top_mm: float) -> Block:
    return Block(
        "plate", True, False, x_mm / 1e3, y_mm / 1e3, top_mm / 1e3, (0.25, 0.2), 0.01, False
    )


def _mine(
    x_mm: float, y_mm: float, top_mm: float, wide_mm: float = 70.0, high_mm: float = 70.0,
    name: str = "mine",
) -> Block:  # fmt: skip
    size_m = (wide_mm / 1e3, wide_mm / 1e3)
    return Block(name, False, False, x_mm / 1e3, y_mm / 1e3, top_mm / 1e3, size_m, high_mm / 1e3)


UNIANDES = (
    (_sphere(175, 525, 100), _plate(525, 525, 150), _plate(175, 175, 50), _mine(525, 175, 100)),
    (
        _sphere(175, 525, 150), _plate(525, 525, 100), _mine(140, 175, 50), _sphere(280, 175, 50),
        _mine(525, 175, 150),
    ),
    (
        _sphere(175, 525, 100), _mine(525, 525, 20), _sphere(175, 175, 150), _mine(525, 175, 50),
        _mine(350, 350, 150),
    ),
    (
        _mine(175, 525, 100), _sphere(525, 525, 10), _sphere(175, 175, 150), _mine(525, 175, 150),
        _plate(350, 350, 100),
    ),
    (
        _mine(350, 525, 80, 66.3, 60.2), _mine(525, 350, 120, 90.2, 46.45, "bottle"),
        _sphere(350, 175, 50), _sphere(175, 350, 70),
    ),
)  # fmt: skip


def uniandes() -> List[AreaScene]:
    """Return the five laboratory scenes at 21 x 21 of their 141 x 141 positions, to 3.5 GHz."""
    return [
        AreaScene(
            f"uniandes_{number}", 2.56, 0.001, 0.4, 0.035, 21, 0.005, 3.5e9, 8.2e-9, 0.3, 0.3, own
        )
        for number, own in enumerate(UNIANDES, 1)
    ]


def draw(seed: int) -> AreaScene:
    """Return the random area of a seed: three to five bodies, half of them level discs."""
    random = np.random.default_rng([30, seed])
    bodies: List[Block] = []
    for _ in range(int(random.integers(3, 6))):
        is_metal, flat = bool(random.random() < 0.4), bool(random.random() < 0.6)
        size_m = float(random.uniform(0.06, 0.12) if flat else random.uniform(0.03, 0.07))
        height_m = float(random.uniform(0.02, 0.04)) if flat else size_m
        top_m = float(random.uniform(0.02, 0.15 - height_m))
        name = ("metal " if is_metal else "plastic ") + ("disc" if flat else "sphere")
        for _ in range(100):
            x_m, y_m = (float(one) for one in random.uniform(0.04, 0.36, 2))
            if all(
                np.hypot(x_m - one.x_m, y_m - one.y_m) > (size_m + one.size_m[0]) / 2.0 + 0.03
                for one in bodies
            ):
                bodies.append(
                    Block(name, is_metal, not flat, x_m, y_m, top_m, (size_m, size_m), height_m)
                )
                break
    return AreaScene(
        f"random_{seed}", float(random.uniform(3.0, 6.0)), float(random.uniform(0.0, 0.02)),
        0.1, 0.02, 21, 0.004, 3.0e9, 5.5e-9, 0.2, 0.2, tuple(bodies),
    )  # fmt: skip


def paint(scene: AreaScene) -> Tuple[Boxes, Materials]:
    """Return the boxes of all positions of a scene, along X first, and the materials."""
    cell_m = scene.cell_m
    separation = round(SEPARATION_M / cell_m)
    half = round(scene.beside_m / cell_m) + ABSORBING_CELLS
    antenna = round(0.05 / cell_m) + ABSORBING_CELLS
    surface = antenna + round(scene.height_m / cell_m)
    depths = surface + round(scene.below_m / cell_m) + ABSORBING_CELLS
    place = np.rint(scene.step_m * np.arange(scene.positions) / cell_m).astype(int)
    cells = int(place[-1]) + 2 * half + 1
    axis_m = (np.arange(cells) - half) * cell_m
    x_m, y_m = axis_m[None, None, :], axis_m[None, :, None]
    depth_m = ((np.arange(depths) - surface + 0.5) * cell_m)[:, None, None]
    ground = np.full((depths, cells, cells), AIR, np.uint8)
    ground[surface:] = SOIL
    for body in scene.bodies:
        ground[_inside(body, x_m, y_m, depth_m)] = METAL if body.is_metal else PLASTIC
    materials = Materials(
        np.array([1.0, scene.permittivity, 1.0, 2.8]),
        np.array([0.0, scene.conductivity_s_per_m, np.inf, 0.0]),
    )
    rows, columns = (one.ravel() for one in np.meshgrid(place, place, indexing="ij"))
    source = half - separation // 2
    return (
        Boxes(
            ground,
            np.stack([rows, columns], axis=1),
            (depths, 2 * half + 1, 2 * half + 1),
            (antenna, half, source),
            (antenna, half, source + separation),
        ),
        materials,
    )


def _inside(body: Block, x_m: np.ndarray, y_m: np.ndarray, depth_m: np.ndarray) -> np.ndarray:
    across_m, along_m = x_m - body.x_m, y_m - body.y_m
    middle_m = depth_m - body.top_m - body.height_m / 2.0
    if body.is_sphere:
        inside: np.ndarray = across_m**2 + along_m**2 + middle_m**2 < (body.height_m / 2.0) ** 2
        return inside
    if body.is_round:
        flat = np.hypot(across_m, along_m) < body.size_m[0] / 2.0
    else:
        flat = (np.abs(across_m) < body.size_m[0] / 2.0) & (np.abs(along_m) < body.size_m[1] / 2.0)
    level: np.ndarray = flat & (np.abs(middle_m) < body.height_m / 2.0)
    return level
