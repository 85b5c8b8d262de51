"""The permittivity from the surface echo of rough soil, by fields of Maxwell's equations.

Usage: scripts/bench.sh surface [--soils 6] [--seed 1]

Plate and soil are computed by finite differences in three dimensions (benchmarks/worlds), with two
dipoles 24 mm apart: a plate at five heights, and random soils whose surface is a random field with
a deviation of up to 5 mm, at four positions each.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from recorded_worlds import dataset
from scipy.ndimage import gaussian_filter

from gpr20_analysis.processing.antenna_step import (
    ENDS,
    SURFACE_PERMITTIVITY,
    antenna_of,
    without_antenna,
)

sys.path.append(str(Path(__file__).resolve().parent / "worlds"))
import area_field
import line_field

CELL_M, SEPARATION_M = 0.004, 0.024
BESIDE, ABOVE, BELOW = 85, 10, 40
PLATE_CELLS = (13, 16, 20, 25, 32)
HIGHEST_CELLS = 36
STOPS = np.array([0, 20])
FREQUENCY_HZ = np.linspace(1e9, 4e9, 61)
RECORD_S = 3.5e-9
SPREAD = BESIDE + area_field.ABSORBING_CELLS
NOISE = 10.0 ** (-65.0 / 20.0)


def measured(
    surface: np.ndarray, permittivity: float, stops: np.ndarray, random: np.random.Generator
) -> np.ndarray:
    """Return the spectra (y, x, frequency) over a surface.

    Args:
        surface: First row of the soil below the antennas in each column (y, x).
        permittivity: Of the soil; infinite: metal.
        stops: First column of the box at each stop.
        random: Of the noise.
    """
    antenna = ABOVE + area_field.ABSORBING_CELLS
    depths = antenna + HIGHEST_CELLS + BELOW + area_field.ABSORBING_CELLS
    ground = (np.arange(depths)[:, None, None] >= antenna + surface).astype(np.uint8)
    metal = np.isinf(permittivity)
    materials = line_field.Materials(
        np.array([1.0, 1.0 if metal else permittivity]), np.array([0.0, np.inf if metal else 0.0])
    )
    rows, columns = (one.ravel() for one in np.meshgrid(stops, stops, indexing="ij"))
    half = round(SEPARATION_M / CELL_M / 2.0)
    places = [(antenna, SPREAD, SPREAD + side * half) for side in (-1, 1)]
    boxes = area_field.Boxes(
        ground, np.stack([rows, columns], 1), (depths, 2 * SPREAD + 1, 2 * SPREAD + 1), *places
    )
    step_s = area_field.step_s(CELL_M)
    sent = line_field.pulse(2.4e9, step_s, round(RECORD_S / step_s))
    echoes = area_field.received(boxes, materials, CELL_M, sent, False)
    s21 = line_field.transfer(echoes, sent, step_s, FREQUENCY_HZ)
    noise = random.standard_normal((*s21.shape, 2)) @ np.array([1.0, 1j]) * np.abs(s21).max()
    found: np.ndarray = (s21 + NOISE * noise).reshape(len(stops), len(stops), -1)
    return found


def main() -> None:
    """Print the permittivity of each soil and what is found from its surface echo."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--soils", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    random = np.random.default_rng(chosen.seed)
    size = 2 * SPREAD + 1
    plates = []
    for cells in PLATE_CELLS:
        flat = np.full((size, size), cells)
        s21 = measured(flat, np.inf, STOPS[:1], random)
        plates.append(dataset(s21, cells * CELL_M, np.zeros(1), np.zeros(1), FREQUENCY_HZ))
    model = antenna_of(plates, SEPARATION_M)
    print(f"plate: misfit {float(model['misfit'].max()):.3f}")
    print("permittivity, height and roughness [mm]: range")
    for _ in range(chosen.soils):
        permittivity = float(np.exp(random.uniform(np.log(2.5), np.log(12.0))))
        cells, rough_m = int(random.integers(18, 32)), float(random.uniform(0.0, 0.005))
        wide = size + int(STOPS[-1])
        field = gaussian_filter(random.standard_normal((wide, wide)), random.uniform(5, 12))
        surface = np.rint(cells - rough_m / CELL_M * field / field.std()).astype(int)
        s21 = measured(surface, permittivity, STOPS, random)
        # The sensor sees a spot of the surface.
        spots = gaussian_filter(surface.astype(float), 5)[SPREAD:, SPREAD:][np.ix_(STOPS, STOPS)]
        place_m = STOPS * CELL_M
        survey = dataset(s21, spots[None] * CELL_M, place_m, place_m, FREQUENCY_HZ)
        found = without_antenna(survey, model).attrs
        lowest, best, highest = (found.get(SURFACE_PERMITTIVITY + end, np.nan) for end in ENDS)
        print(
            f"{permittivity:.2f}, {1e3 * cells * CELL_M:.0f}, {1e3 * rough_m:.1f}: "
            f"{lowest:.2f} to {highest:.2f} ({best:.2f})",
            flush=True,
        )


if __name__ == "__main__":
    main()
