"""The ground of a scene: what the antennas receive over it.

A ray model: direct coupling, the echo of the surface, and targets as point scatterers in a
uniform half space below an air gap, with refraction at the surface. No multiple echoes and
no dispersion. Time convention exp(-2j pi f t): an inverse Fourier transform of S21 shows an
echo at its positive delay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_simulator.mid.antenna_position import AntennaPosition
from gpr20_simulator.mid.refraction import (
    SPEED_OF_LIGHT_M_S,
    RefractedPath,
    refracted_path,
)
from gpr20_simulator.mid.scatterers import scatterers_of
from gpr20_simulator.mid.scene import Scene, amplitude

# Path at which the strengths of a scene are given.
REFERENCE_M = 0.1
SMALLEST_HEIGHT_M = 0.005


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
        surface = self._scene.surface
        x_m, y_m = x_mm / 1000.0, y_mm / 1000.0
        turns_per_m = 2.0 * math.pi / surface.wave_length_m
        wave = math.sin(turns_per_m * x_m) * math.sin(turns_per_m * y_m)
        return surface.slope_x * x_m + surface.slope_y * y_m + surface.wave_amplitude_m * wave

    def antenna_height_m(self, x_mm: float, y_mm: float) -> float:
        """Return the height of the antennas above the surface below them [m]."""
        return self._scene.antennas.height_m - self.surface_height_m(x_mm, y_mm)

    def s21(
        self, frequency_hz: np.ndarray, position: AntennaPosition, sweep_number: int
    ) -> np.ndarray:
        """Return the complex transmission at each frequency [Hz], with noise."""
        echoes = self.echoes(position)
        exponent = np.outer(frequency_hz, -2j * np.pi * echoes.delay_s - echoes.decay_s)
        return np.exp(exponent) @ echoes.level + self._noise(len(frequency_hz))

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
        return Echoes(
            np.concatenate(
                [
                    [amplitude(antennas.coupling_level_db)],
                    [self._surface_level(surface_path_m)],
                    targets.level,
                ]
            ),
            np.concatenate(
                [
                    [antennas.coupling_delay_s],
                    [surface_path_m / SPEED_OF_LIGHT_M_S],
                    targets.delay_s,
                ]
            ),
            np.concatenate([[0.0, 0.0], targets.decay_s]),
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
        receiver = self._path_from(position, height_m, -0.5)
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
        """Return the paths from one antenna, which stands to one side of the middle."""
        rotation_rad = math.radians(position.rotation_deg)
        offset_m = side * self._scene.antennas.separation_m
        x_m = position.x_mm / 1000.0 + offset_m * math.cos(rotation_rad)
        y_m = position.y_mm / 1000.0 + offset_m * math.sin(rotation_rad)
        distance_m = np.hypot(self._points.x_m - x_m, self._points.y_m - y_m)
        # The surface is taken as level where the antennas are, at the height it has there.
        depth_m = self._points.depth_m + self.surface_height_m(position.x_mm, position.y_mm)
        permittivity = self._scene.soil.relative_permittivity
        return refracted_path(height_m, depth_m, distance_m, permittivity)

    def _noise(self, count: int) -> np.ndarray:
        parts = self._random.standard_normal((count, 2)) * (self._noise_level / math.sqrt(2.0))
        return parts[:, 0] + 1j * parts[:, 1]


def _one_way_level(path: RefractedPath) -> np.ndarray:
    """Return the share of the field that arrives: spreading, and the antenna's cosine pattern."""
    return REFERENCE_M / (path.air_m + path.soil_m) * path.cos_air
