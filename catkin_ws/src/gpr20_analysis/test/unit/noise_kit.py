"""Images of noise, and what every imaging method must do with noise."""

from __future__ import annotations

import os

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.dataset import NOISE, S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.processing.background import remove_background
from gpr20_survey.radar.refraction import one_way_delay_s

HEIGHT_M = 0.2
DEPTH_M = tuple(np.arange(0.0, 0.2001, 0.008))
# More surveys for the table in docs/imaging.md: scripts/bench.sh detection.
SURVEYS = int(os.environ.get("GPR20_NOISE_SURVEYS", "8"))


def noise(random, shape):
    return random.standard_normal((*shape, 2)) @ np.array([1.0, 1j]) / np.sqrt(2.0)


def survey(random, level=1.0, targets=(), places=17, points=151, rotations=(0.0, 90.0)):
    """Return noise, and points as bright as 1 in a trace above them."""
    place_m = 0.015 * np.arange(places)
    frequency_hz = np.linspace(600e6, 6e9, points)
    shape = (len(rotations), places, places)
    s21 = level * noise(random, (*shape, points))
    for x_m, y_m, depth_m in targets:
        across_m = np.hypot(place_m[None, :] - x_m, place_m[:, None] - y_m)
        delay_s = 2.0 * one_way_delay_s(HEIGHT_M, depth_m, across_m, 4.0)
        s21 += np.exp(-2j * np.pi * frequency_hz * delay_s[..., None])
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21),
            "height": (SAMPLE_DIMS, np.full(shape, HEIGHT_M)),
            "quality": (SAMPLE_DIMS, np.zeros(shape, dtype=np.uint8)),
        },
        {"polarization": list(rotations), "y": place_m, "x": place_m, "frequency": frequency_hz},
        {"missing": [], "faults": [], "notes": []},
    )


def imaged(data, method=Method.PHASE_SHIFT, depth_m=DEPTH_M, **options):
    return image_survey(remove_background(data), ImageOptions(method, 4.0, depth_m, **options))


def level_over_noise(image):
    """Return the magnitudes of an image in the unit of its noise."""
    over = image.noise_over_y.values[:, None] * image.noise_over_x.values
    return np.abs(image.image.values) / (image[NOISE].values[..., None, None] * over)


def noise_level_db(method, level):
    """Return the mean level of noise in images of noise alone, above the noise they state [dB]."""
    found = []
    for seed in range(2):
        image = imaged(survey(np.random.default_rng(seed), level, rotations=(0.0,)), method)
        found.append(np.mean(np.log(level_over_noise(image))) - method.law.mean_log)
    return float(method.law.level_db(np.exp(np.mean(found))))


def share_of_alarms(method):
    """Return the share of images of noise with a candidate where half of them should have one."""
    count = 0
    for seed in range(SURVEYS):
        image = imaged(survey(np.random.default_rng(100 + seed), rotations=(0.0,)), method)
        count += bool(find_candidates(image, CandidateOptions(0.5)).candidates)
        assert not find_candidates(image, CandidateOptions(1e-5)).candidates
    return count / SURVEYS


def errors_in_uncertainties(method):
    """Return the errors of candidates along x, y and depth, in their uncertainties."""
    errors = []
    for seed in range(2):
        random = np.random.default_rng(seed)
        target = (*random.uniform(0.07, 0.17, 2), random.uniform(0.08, 0.14))
        data = survey(random, 0.1, [target], rotations=(0.0,))
        found = find_candidates(imaged(data, method, tuple(np.arange(0.0, 0.2, 0.003)))).candidates
        # The nearest, because products of the Kirchhoff methods can be brighter.
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
