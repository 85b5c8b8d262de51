"""Where point targets come out in an image, how wide, and with what sidelobes, against theory.

Usage: scripts/bench.sh imaging_accuracy [--targets 10] [--permittivity 4]

Each target lies alone, at a random place off the grid, below 41 x 41 positions of 10 mm step, with
noise 30 dB below its strongest echo at each frequency. Theory is the response of a matched filter
to a point: the sum over all traces and frequencies of exp(2j pi f (delay there - delay here)), with
the same weights over the band, computed on a line through the target. In depth it is close to
1.44 c / (2 B sqrt(er)) for a Hann window; across no closed form holds for waves from all angles.
"""

from __future__ import annotations

import argparse
import math
from typing import Dict, List, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_survey.radar.frequency_to_delay import Window
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.results.candidates import Candidate

PLACE_M = 0.05 + 0.010 * np.arange(41)
HEIGHT_M = 0.20
FREQUENCY_HZ = np.linspace(600e6, 6e9, 501)
DEPTH_M = tuple(np.arange(0.0, 0.2501, 0.0025))
NOISE = 10.0 ** (-30.0 / 20.0)
MM = 1e3
Place = Tuple[float, float, float]
Found = Tuple[Candidate, Tuple[float, ...], Place, float]


def survey(target: Place, permittivity: float, random: np.random.Generator) -> xr.Dataset:
    x_m, y_m, depth_m = target
    across_m = np.hypot(PLACE_M[None, :] - x_m, PLACE_M[:, None] - y_m)
    delay_s = 2.0 * one_way_delay_s(HEIGHT_M, depth_m, across_m, permittivity)
    level = (delay_s.min() / delay_s) ** 2
    s21 = level[..., None] * np.exp(-2j * np.pi * FREQUENCY_HZ * delay_s[..., None])
    s21 += NOISE * (random.standard_normal((*s21.shape, 2)) @ np.array([1.0, 1j])) / np.sqrt(2.0)
    shape = (1, *delay_s.shape)
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21[None]),
            "height": (SAMPLE_DIMS, np.full(shape, HEIGHT_M)),
            "quality": (SAMPLE_DIMS, np.zeros(shape, dtype=np.uint8)),
        },
        {"polarization": [0.0], "y": PLACE_M, "x": PLACE_M, "frequency": FREQUENCY_HZ},
    )


def theoretical_widths_mm(target: Place, permittivity: float) -> Tuple[float, float]:
    """Return the -3 dB widths of the matched filter's response, along X and in depth [mm]."""
    x_m, y_m, depth_m = target
    weights = Window.HANN.weights(FREQUENCY_HZ.size)
    away_m = np.linspace(-0.05, 0.05, 101)

    def delays_s(x_there: float, depth_there: float) -> np.ndarray:
        across_m = np.hypot(PLACE_M[None, :] - x_there, PLACE_M[:, None] - y_m)
        return 2.0 * one_way_delay_s(HEIGHT_M, depth_there, across_m, permittivity)

    here_s = delays_s(x_m, depth_m)
    level = ((here_s.min() / here_s) ** 2).ravel()

    def response(there_s: np.ndarray) -> float:
        turns = np.outer(FREQUENCY_HZ, (there_s - here_s).ravel())
        return float(abs(weights @ np.exp(2j * np.pi * turns) @ level))

    along_x = np.array([response(delays_s(x_m + d, depth_m)) for d in away_m])
    in_depth = np.array([response(delays_s(x_m, max(depth_m + d, 0.0))) for d in away_m])
    return _width_mm(along_x, away_m), _width_mm(in_depth, away_m)


def _width_mm(response: np.ndarray, away_m: np.ndarray) -> float:
    fine_m = np.linspace(away_m[0], away_m[-1], 10001)
    above = np.interp(fine_m, away_m, response) >= response.max() / np.sqrt(2.0)
    middle = fine_m.size // 2
    left = middle - int(np.argmin(above[middle::-1]))
    right = middle + int(np.argmin(above[middle:]))
    return float(fine_m[right] - fine_m[left]) * MM


def half_power_widths_m(volume: np.ndarray, axes: Sequence[np.ndarray]) -> Tuple[float, ...]:
    """Return the -3 dB widths of the brightest voxel along depth, y and x [m].

    NaN where the image ends before.
    """
    place = tuple(int(one) for one in np.unravel_index(int(np.argmax(volume)), volume.shape))
    lines = (
        volume[tuple(slice(None) if other == axis else place[other] for other in range(3))]
        for axis in range(3)
    )
    return tuple(_half_power_width_m(*one) for one in zip(lines, axes, place))


def _half_power_width_m(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    """Return the -3 dB width of a maximum; NaN if the line ends above that level."""
    level = float(line[index]) / math.sqrt(2.0)
    below = np.flatnonzero(line <= level)
    left, right = below[below < index], below[below > index]
    if not left.size or not right.size:
        return math.nan
    ends = [
        np.interp(level, line[[low, high]], axis[[low, high]])
        for low, high in ((left[-1], left[-1] + 1), (right[0], right[0] - 1))
    ]
    return float(ends[1] - ends[0])


def sidelobe_db(image: xr.Dataset, target: Place) -> float:
    """Return the highest voxel 50..150 mm away, below the target's [dB]."""
    x_m, y_m, depth_m = target
    magnitude = abs(image.image[0])
    away_m = np.sqrt((image.x - x_m) ** 2 + (image.y - y_m) ** 2 + (image.depth - depth_m) ** 2)
    ring = magnitude.where((away_m > 0.05) & (away_m < 0.15))
    return float(20.0 * np.log10(ring.max() / magnitude.max()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--targets", type=int, default=10)
    parser.add_argument("--permittivity", type=float, default=4.0)
    chosen = parser.parse_args()
    random = np.random.default_rng(8)
    found: Dict[Method, List[Found]] = {method: [] for method in Method}
    theory = []
    for _ in range(chosen.targets):
        x_m, y_m = random.uniform(0.15, 0.35, 2)
        target = (float(x_m), float(y_m), float(random.uniform(0.05, 0.18)))
        theory.append(theoretical_widths_mm(target, chosen.permittivity))
        data = survey(target, chosen.permittivity, random)
        for method in Method:
            options = ImageOptions(method, chosen.permittivity, DEPTH_M)
            image = image_survey(data, options)
            best = find_candidates(image).candidates[0]
            axes = [image[name].values for name in ("depth", "y", "x")]
            widths = half_power_widths_m(abs(image.image[0].values), axes)
            found[method].append((best, widths, target, sidelobe_db(image, target)))
    across, in_depth = np.mean(theory, axis=0)
    bound = 1.44 * speed_of_light / (2.0 * np.ptp(FREQUENCY_HZ)) * MM
    print(f"theory: -3 dB width {across:.1f} mm across, {in_depth:.1f} mm in depth")
    print(f"1.44 c / (2 B sqrt(er)) = {bound / np.sqrt(chosen.permittivity):.1f} mm")
    print("method           mean error x, y, depth mm   3D error median, max mm   "
          "width x, depth mm   sidelobe dB")  # fmt: skip
    for method, ones in found.items():
        _show(method, ones)


def _show(method: Method, ones: List[Found]) -> None:
    errors = MM * np.array(
        [[e.x_m - x, e.y_m - y, e.depth_m - depth] for e, _, (x, y, depth), _ in ones]
    )
    away = np.linalg.norm(errors, axis=1)
    mean = errors.mean(axis=0)
    print(
        f"{method.value:16} {mean[0]:+7.2f} {mean[1]:+7.2f} {mean[2]:+7.2f}"
        f"{np.median(away):14.2f} {away.max():9.2f}"
        f"{MM * np.mean([widths[2] for _, widths, _, _ in ones]):18.1f} "
        f"{MM * np.mean([widths[0] for _, widths, _, _ in ones]):6.1f}"
        f"{np.mean([level for _, _, _, level in ones]):15.1f}"
    )


if __name__ == "__main__":
    main()
