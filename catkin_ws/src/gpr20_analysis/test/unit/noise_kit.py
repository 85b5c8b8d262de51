"""Surveys of points in noise, and their images."""

import numpy as np
from ground_kit import dataset_of

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.processing.background import remove_background
from gpr20_survey.radar import one_way_delay_s

HEIGHT_M = 0.2
DEPTH_M = tuple(np.arange(0.0, 0.2001, 0.008))
PLACE_M = 0.015 * np.arange(17)
FREQUENCY_HZ = np.linspace(600e6, 6e9, 151)


def noise(random, shape):
    return random.standard_normal((*shape, 2)) @ np.array([1.0, 1j]) / np.sqrt(2.0)


def survey(
    random, level=1.0, targets=(), rotations=(0.0, 90.0), place_m=PLACE_M, frequency_hz=FREQUENCY_HZ
):
    """Return noise, and points of x, y, depth and their level in a trace (default 1) in it."""
    shape = (len(rotations), len(place_m), len(place_m))
    s21 = level * noise(random, (*shape, len(frequency_hz)))
    for x_m, y_m, depth_m, *strength in targets:
        across_m = np.hypot(place_m[None, :] - x_m, place_m[:, None] - y_m)
        delay_s = 2.0 * one_way_delay_s(HEIGHT_M, depth_m, across_m, 4.0)
        # It spreads on both ways, and the antennas see less aslant.
        cosine = (HEIGHT_M + depth_m) / np.hypot(HEIGHT_M + depth_m, across_m)
        spread = (cosine * delay_s.min() / delay_s) ** 2
        echo = spread[..., None] * np.exp(-2j * np.pi * frequency_hz * delay_s[..., None])
        s21 += echo * (strength[0] if strength else 1.0)
    return dataset_of(s21, np.full(shape, HEIGHT_M), rotations, place_m, place_m, frequency_hz)


def imaged(data, method=Method.PHASE_SHIFT, depth_m=DEPTH_M, **options):
    return image_survey(remove_background(data), ImageOptions(method, 4.0, depth_m, **options))


def errors_in_uncertainties(method):
    """Return the errors of candidates along x, y and depth, in their uncertainties."""
    errors = []
    for seed in range(2):
        random = np.random.default_rng(seed)
        target = (*random.uniform(0.07, 0.17, 2), random.uniform(0.08, 0.14))
        data = survey(random, 0.1, [target], rotations=(0.0,))
        found = find_candidates(imaged(data, method, tuple(np.arange(0.0, 0.2, 0.003)))).candidates
        x_m, y_m, depth_m = target
        one = min(found[:5], key=lambda one: abs(one.x_m - x_m) + abs(one.depth_m - depth_m))
        errors.append(
            (
                (one.x_m - x_m) / one.x_uncertainty_m,
                (one.y_m - y_m) / one.y_uncertainty_m,
                (one.depth_m - depth_m) / one.depth_uncertainty_m,
            )
        )
    return np.sqrt(np.mean(np.square(errors), axis=0))
