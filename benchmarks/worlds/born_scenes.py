"""Random areas over a half space with one body, or one beside a fragment that outshines it.

Two dipoles along Y, 60 mm apart along X, as in `area_scenes`. The field in a sphere is taken as
3 eps / (eps_body + 2 eps) of that without it, the static value. In a level disc it is taken as that
without it: most of it is along the faces, where it is continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
from born_body import Antennas, Layers, pitch_m, scattered
from born_field import Soil, coupling, surface_echo

FREQUENCY_HZ = np.linspace(1e9, 5e9, 51)
SEPARATION_M, STEP_M, POSITIONS = 0.06, 0.02, 31
SEED = 33
PLASTIC, VOID, STONE, METAL = 2.8, 1.0, 12.0, 1e6


@dataclass(frozen=True)
class Body:
    """One body.

    Attributes:
        name: What it is.
        permittivity: Its relative permittivity.
        is_sphere: Whether it is a sphere; otherwise it is a level disc.
        x_m: Its middle along X [m].
        y_m: Its middle along Y [m].
        top_m: Depth of its top [m].
        size_m: Its diameter along X and Y [m].
        height_m: Its height [m].
        stronger_db: Its echo over that of the first body, where either is strongest, as mean
            power over frequencies; 0: as it is computed.
    """

    name: str
    permittivity: float
    is_sphere: bool
    x_m: float
    y_m: float
    top_m: float
    size_m: Tuple[float, float]
    height_m: float
    stronger_db: float = 0.0


@dataclass(frozen=True)
class BornScene:
    """One area.

    Attributes:
        name: Its name.
        permittivity: Relative permittivity of the soil.
        conductivity_s_per_m: Its conductivity [S/m].
        height_m: Height of the antennas [m].
        bodies: What is buried.
    """

    name: str
    permittivity: float
    conductivity_s_per_m: float
    height_m: float
    bodies: Tuple[Body, ...]


def draw(number: int) -> BornScene:
    """Return a scene: of five, three have a plastic disc, one a sphere, one disc and fragment."""
    random = np.random.default_rng([SEED, number])
    permittivity = float(random.uniform(3.0, 9.0))
    pitch = pitch_m(FREQUENCY_HZ[-1], permittivity, STEP_M)
    x_m, y_m = (float(one) for one in pitch * np.rint(random.uniform(0.12, 0.48, 2) / pitch))
    top_m = float(random.uniform(0.03, 0.15))
    kind = number % 5
    if kind == 3:
        name, own = (("void", VOID), ("stone", STONE))[number // 5 % 2]
        size_m = 2.0 * float(random.uniform(0.01, 0.02))
        bodies = [Body(name, own, True, x_m, y_m, top_m, (size_m, size_m), size_m)]
    else:
        size_m = 2.0 * float(random.uniform(0.03, 0.06))
        thick_m = float(random.uniform(0.02, 0.04))
        name = "plastic disc beside a fragment" if kind == 4 else "plastic disc"
        bodies = [Body(name, PLASTIC, False, x_m, y_m, top_m, (size_m, size_m), thick_m)]
    if kind == 4:
        bodies.append(_fragment(random, bodies[0], pitch))
    return BornScene(
        f"born_{number}", permittivity, float(random.uniform(0.0, 0.01)),
        float(random.uniform(0.06, 0.15)), tuple(bodies),
    )  # fmt: skip


def _fragment(random: np.random.Generator, beside: Body, pitch: float) -> Body:
    top_m, stronger_db = float(random.uniform(0.03, 0.12)), float(random.uniform(10.0, 24.0))
    while True:
        away_m, turn = random.uniform(0.1, 0.25), random.uniform(0.0, 2.0 * np.pi)
        middle_m = np.array([beside.x_m, beside.y_m])
        middle_m += away_m * np.array([np.cos(turn), np.sin(turn)])
        if middle_m.min() > 0.05 and middle_m.max() < 0.55:
            x_m, y_m = (float(one) for one in pitch * np.rint(middle_m / pitch))
            return Body(
                "fragment", METAL, True, x_m, y_m, top_m, (0.01, 0.01), 0.01, stronger_db
            )  # fmt: skip


def echoes(scene: BornScene) -> Tuple[np.ndarray, np.ndarray]:
    """Return the fields of coupling and surface (frequency), and of bodies (y, x, frequency)."""
    soil = Soil(scene.permittivity, scene.conductivity_s_per_m)
    antennas = Antennas(scene.height_m, SEPARATION_M, POSITIONS, STEP_M)
    pitch = pitch_m(FREQUENCY_HZ[-1], scene.permittivity, STEP_M)
    level: List[complex] = []
    found: List[List[np.ndarray]] = []
    for frequency_hz in FREQUENCY_HZ:
        here = soil.at(frequency_hz)
        echo = surface_echo(frequency_hz, here, scene.height_m, SEPARATION_M)
        level.append(coupling(frequency_hz, SEPARATION_M) + echo)
        found.append(
            [
                _response(here, body)
                * scattered(frequency_hz, here, antennas, _layers(body, pitch), pitch)
                for body in scene.bodies
            ]
        )
    of_each = np.moveaxis(np.array(found), 0, -1)
    strongest = np.sqrt((np.abs(of_each) ** 2).mean(axis=-1)).max(axis=(1, 2))
    for place, body in enumerate(scene.bodies):
        if body.stronger_db:
            of_each[place] *= 10.0 ** (body.stronger_db / 20.0) * strongest[0] / strongest[place]
    return np.array(level), of_each.sum(axis=0)


def _response(soil: complex, body: Body) -> complex:
    """Return the difference of permittivities times the field in the body over that without it."""
    inside = 3.0 * soil / (body.permittivity + 2.0 * soil) if body.is_sphere else 1.0
    return (body.permittivity - soil) * inside


def _layers(body: Body, pitch: float) -> Layers:
    at_m = (body.x_m, body.y_m, body.top_m)
    return Layers.of(at_m, body.size_m[0], body.height_m, body.is_sphere, pitch)
