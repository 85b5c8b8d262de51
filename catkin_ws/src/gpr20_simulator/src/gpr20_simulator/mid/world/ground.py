"""The ground of a scene: what the antennas receive over it.

A ray model: direct coupling, the echo of the surface, and targets as point scatterers in a
uniform half space below an air gap, with refraction at the surface. No multiple echoes and
no dispersion. Time convention exp(-2j pi f t): an inverse Fourier transform of S21 shows an
echo at its positive delay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple, Union

import numpy as np

from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Scene, Shape, Target, amplitude

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


SPEED_OF_LIGHT_M_S = 299_792_458.0
# Each round compares the times at so many crossings and continues between the neighbours of the
# best: 1e-5 of the horizontal distance at the end.
CROSSINGS, ROUNDS = 40, 4
# Path at which the strengths of a scene are given.
REFERENCE_M = 0.1
SMALLEST_HEIGHT_M = 0.005
SMALLEST_DEPTH_M = 1e-4
# Each brings the place where a path meets the surface nearer by the slope, 0.2 at most.
SURFACE_ROUNDS = 6
# 1e-6 rad at 6 GHz: further rounds change nothing that can be measured.
SURFACE_TOLERANCE_M = 1e-8
# Steps of a sweep that differ by less count as equal: a fraction of a step.
EQUAL_STEPS = 1e-9


@dataclass(frozen=True)
class Echoes:
    """Everything received at one position, one item per way the wave can take.

    Attributes:
        level: Magnitude with sign at 0 Hz.
        delay_s: Delay [s].
        decay_s: Attenuation by the soil, in nepers per hertz.
    """

    level: np.ndarray
    delay_s: np.ndarray
    decay_s: np.ndarray


class Ground:
    """Computes S21 over a scene; a `SweptMedium`.

    Args:
        scene: What is there.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._points = scatterers_of(scene.targets)
        self._random = np.random.default_rng(scene.noise.seed)
        self._noise_level = amplitude(scene.noise.level_db)
        self._last: Optional[Tuple[AntennaPosition, Echoes]] = None

    def surface_height_m(self, x_mm: float, y_mm: float) -> float:
        """Return the height of the surface above the plane z = 0 [m]."""
        return float(self._surface_m(np.array(x_mm / 1000.0), np.array(y_mm / 1000.0)))

    def antenna_height_m(self, x_mm: float, y_mm: float) -> float:
        """Return the height of the antennas above the surface below them [m]."""
        return self._scene.antennas.height_m - self.surface_height_m(x_mm, y_mm)

    def s21(
        self,
        frequency_hz: np.ndarray,
        position: AntennaPosition,
        sweep_number: int,
        noise_gain: float = 1.0,
    ) -> np.ndarray:
        """Return the complex transmission at each frequency [Hz], with noise."""
        echoes = self.echoes(position)
        rate_s = -2j * np.pi * echoes.delay_s - echoes.decay_s
        received = sum_of_exponentials(frequency_hz, rate_s, echoes.level)
        return received + noise_gain * self._noise(len(frequency_hz))

    def echoes(self, position: AntennaPosition) -> Echoes:
        """Return what comes back at a position."""
        # Most sweeps are made where the one before was made.
        if self._last is None or self._last[0] != position:
            self._last = (position, self._echoes(position))
        return self._last[1]

    def _echoes(self, position: AntennaPosition) -> Echoes:
        antennas = self._scene.antennas
        height_m = max(self.antenna_height_m(position.x_mm, position.y_mm), SMALLEST_HEIGHT_M)
        surface_path_m = math.hypot(2.0 * height_m, antennas.separation_m)
        targets = self._target_echoes(position, height_m)
        coupling = amplitude(antennas.coupling_level_db)
        surface_s = surface_path_m / SPEED_OF_LIGHT_M_S
        return Echoes(
            np.r_[coupling, self._surface_level(surface_path_m), targets.level],
            antennas.delay_s + np.r_[antennas.coupling_delay_s, surface_s, targets.delay_s],
            np.r_[0.0, 0.0, targets.decay_s],
        )

    def _surface_level(self, path_m: float) -> float:
        index = math.sqrt(self._scene.soil.relative_permittivity)
        reflection = (1.0 - index) / (1.0 + index)
        return amplitude(self._scene.antennas.surface_gain_db) * reflection * REFERENCE_M / path_m

    def _target_echoes(self, position: AntennaPosition, height_m: float) -> Echoes:
        soil, points = self._scene.soil, self._points
        index = math.sqrt(soil.relative_permittivity)
        rotation_rad = math.radians(position.rotation_deg)
        transmitter = self._path_from(position, height_m, +0.5)
        receiver = (
            self._path_from(position, height_m, -0.5)
            if self._scene.antennas.separation_m
            else transmitter
        )
        # A sphere reflects from its near side, on the way to its centre.
        air_m = transmitter.air_m + receiver.air_m
        soil_m = transmitter.soil_m + receiver.soil_m - 2.0 * points.radius_m
        # Co-polar response of a diagonal scattering matrix to antennas turned by the rotation.
        strength = (
            points.x_pol_strength * math.cos(rotation_rad) ** 2
            + points.y_pol_strength * math.sin(rotation_rad) ** 2
        )
        through_surface = 4.0 * index / (1.0 + index) ** 2
        spreading = _one_way_level(transmitter) * _one_way_level(receiver)
        return Echoes(
            strength * through_surface * spreading,
            (air_m + index * soil_m) / SPEED_OF_LIGHT_M_S,
            math.pi * index * soil.loss_tangent * soil_m / SPEED_OF_LIGHT_M_S,
        )

    def _path_from(self, position: AntennaPosition, height_m: float, side: float) -> RefractedPath:
        """Return the paths from one antenna, which is to one side of the middle."""
        rotation_rad = math.radians(position.rotation_deg)
        offset_m = side * self._scene.antennas.separation_m
        x_m = position.x_mm / 1000.0 + offset_m * math.cos(rotation_rad)
        y_m = position.y_mm / 1000.0 + offset_m * math.sin(rotation_rad)
        aside_x_m, aside_y_m = self._points.x_m - x_m, self._points.y_m - y_m
        distance_m = np.hypot(aside_x_m, aside_y_m)
        permittivity = self._scene.soil.relative_permittivity
        here_m = self.surface_height_m(position.x_mm, position.y_mm)
        top_m, surface_m = height_m + here_m, np.full(distance_m.shape, here_m)
        # By Fermat's principle the delay is right to the first order of the slope if the surface
        # is taken as level at the height it has where the path meets it.
        for _ in range(SURFACE_ROUNDS):
            path = refracted_path(
                np.maximum(top_m - surface_m, SMALLEST_HEIGHT_M),
                np.maximum(self._points.depth_m + surface_m, SMALLEST_DEPTH_M),
                distance_m,
                permittivity,
            )
            share = path.across_air_m / np.maximum(distance_m, SMALLEST_DEPTH_M)
            before_m = surface_m
            surface_m = self._surface_m(x_m + share * aside_x_m, y_m + share * aside_y_m)
            if np.abs(surface_m - before_m).max(initial=0.0) < SURFACE_TOLERANCE_M:
                break
        return path

    def _surface_m(self, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        surface = self._scene.surface
        turns_per_m = 2.0 * math.pi / surface.wave_length_m
        wave = np.sin(turns_per_m * x_m) * np.sin(turns_per_m * y_m)
        rise_m: np.ndarray = (
            surface.slope_x * x_m + surface.slope_y * y_m + surface.wave_amplitude_m * wave
        )
        return rise_m

    def _noise(self, count: int) -> np.ndarray:
        parts = self._random.standard_normal((count, 2)) * (self._noise_level / math.sqrt(2.0))
        return parts[:, 0] + 1j * parts[:, 1]


def sum_of_exponentials(
    frequency_hz: np.ndarray, rate_s: np.ndarray, level: np.ndarray
) -> np.ndarray:
    """Return the sum of level * exp(rate_s * frequency_hz) at each frequency.

    Exponentials take most of the time of a sweep. In a sweep of N equal steps each of them is the
    product of two, of the first frequency of a block and of the place in the block: 2 sqrt(N)
    exponentials for each item instead of N.
    """
    steps_hz = np.diff(frequency_hz)
    if not len(steps_hz) or np.ptp(steps_hz) > EQUAL_STEPS * abs(steps_hz[0]):
        direct: np.ndarray = np.exp(np.outer(frequency_hz, rate_s)) @ level
        return direct
    block = math.ceil(math.sqrt(len(frequency_hz)))
    step_hz = (frequency_hz[-1] - frequency_hz[0]) / len(steps_hz)
    blocks = np.exp(np.outer(frequency_hz[::block], rate_s)) * level
    places = np.exp(np.outer(step_hz * np.arange(block), rate_s))
    received: np.ndarray = (blocks @ places.T).ravel()[: len(frequency_hz)]
    return received


def _one_way_level(path: RefractedPath) -> np.ndarray:
    """Return the share of the field that arrives: spreading, and the antenna's cosine pattern."""
    return REFERENCE_M / (path.air_m + path.soil_m) * path.cos_air


# The path of a wave from an antenna in air to a point in the soil, by Fermat's principle: of all
# points of the surface it crosses at the one with the shortest time. Nothing else is assumed,
# neither Snell's law nor an angle: the analysis uses those, so the two can disagree.


@dataclass(frozen=True)
class RefractedPath:
    """One way from the antenna to each of several points.

    Attributes:
        air_m: Length in air [m].
        soil_m: Length in soil [m].
        cos_air: Cosine of the angle to the vertical in air.
        across_air_m: Horizontal distance to where the path meets the surface [m].
    """

    air_m: np.ndarray
    soil_m: np.ndarray
    cos_air: np.ndarray
    across_air_m: np.ndarray


def refracted_path(
    height_m: Union[float, np.ndarray],
    depth_m: np.ndarray,
    distance_m: np.ndarray,
    permittivity: float,
) -> RefractedPath:
    """Find the quickest paths through a flat surface.

    Args:
        height_m: Height of the antenna above the surface of each point [m], more than 0.
        depth_m: Depth of each point below the surface [m], more than 0.
        distance_m: Horizontal distance of each point [m].
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    across_m = _quickest_crossing_m(height_m, depth_m, distance_m, math.sqrt(permittivity))
    air_m = np.hypot(height_m, across_m)
    return RefractedPath(
        air_m, np.hypot(depth_m, distance_m - across_m), height_m / air_m, across_m
    )


def _quickest_crossing_m(
    height_m: Union[float, np.ndarray], depth_m: np.ndarray, distance_m: np.ndarray, index: float
) -> np.ndarray:
    """Return where the sum of the path in air and index times that in soil is smallest."""
    above, below = np.square(height_m), np.square(depth_m)
    places = np.arange(CROSSINGS)[:, np.newaxis]
    columns = np.arange(distance_m.size)
    first_m, step_m = np.zeros_like(distance_m), distance_m / (CROSSINGS - 1)
    for _ in range(ROUNDS):
        across_m = first_m + places * step_m
        times_m = np.sqrt(above + across_m**2)
        times_m += index * np.sqrt(below + (distance_m - across_m) ** 2)
        # The time has one minimum, so that it is between the neighbours of the smallest.
        best = np.clip(times_m.argmin(axis=0), 1, CROSSINGS - 2)
        middle_m, spacing_m = across_m[best, columns], step_m
        first_m, step_m = middle_m - spacing_m, 2.0 * spacing_m / (CROSSINGS - 1)
    # The vertex of the parabola through the last three.
    before, here, after = (times_m[best + one, columns] for one in (-1, 0, 1))
    bend = before - 2.0 * here + after
    offset = np.divide(before - after, 2.0 * bend, out=np.zeros_like(bend), where=bend > 0.0)
    return middle_m + spacing_m * np.clip(offset, -1.0, 1.0)
