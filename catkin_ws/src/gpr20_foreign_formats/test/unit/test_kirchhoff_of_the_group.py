"""The Kirchhoff methods against the algorithm that the GPR-20 group publishes.

The reference is written from a description of the published program, with sums and loops in place
of its transforms and tables."""

import math

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from noise_kit import errors_in_uncertainties

from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_common.faults import NOT_ALLOWED
from gpr20_foreign_formats.kirchhoff import KIRCHHOFF, KIRCHHOFF_2D

SPEED_M_S = 3e8
LAST_M = 0.24
# First and last frequency [MHz] and points; zeros below the band, samples dropped at the start and
# sample time [ps], as the published program has them under numpy 1.26 on x86-64.
SWEEPS = [
    (600, 6000, 101, 11, 0, 82.8829),
    (600, 6000, 201, 22, 1, 83.2579),
]


def correlation(one, other):
    return np.corrcoef(one.ravel(), other.ravel())[0, 1]


def published_a_scans(s21, zeros, dropped):
    """Return the real A-scans (y, x, sample) by the cosine sum that the mirrored spectrum is."""
    count = s21.shape[-1]
    length = zeros + count
    window = [0.54 - 0.46 * math.cos(2.0 * math.pi * k / (count - 1)) for k in range(count)]
    # The mirror image repeats the sample at 0 Hz, so the frequencies are odd multiples of half a
    # step, and the trace turns by half a period while the real part alone is kept.
    halves = 2 * (zeros + np.arange(count)) + 1
    n = np.arange(dropped, length)
    turns = np.exp(1j * np.pi * np.outer(halves, n) / (2 * length))
    taper = np.cos(np.pi * n / (2 * length)) / length
    a_scans = np.real((s21 * window) @ turns) * taper
    return a_scans - a_scans.mean(axis=(0, 1))


def published_line(a_scans, place_m, depths_m, height_m, permittivity, sample_s):
    """Return the migrated line (depth, position)."""
    root = math.sqrt(permittivity)
    last = a_scans.shape[1] - 1
    # sqrt(2 pi |f|) over the places of a frequency axis, cos(45 deg) of it real.
    gain = [math.sqrt(math.pi * abs(2 * n - last) / last / 2.0 / sample_s) for n in range(last + 1)]
    grid = [0.5 * math.pi * k / 255 for k in range(256)]
    pairs = [(math.asin(min(root * math.sin(soil), 1.0)), soil) for soil in grid]
    image = np.empty((len(depths_m), len(place_m)))
    for row, depth_m in enumerate(depths_m):
        reach_m = np.array(
            [depth_m * math.tan(soil) + height_m * math.tan(air) for air, soil in pairs]
        )
        for column, x_m in enumerate(place_m):
            values = []
            for trace, antenna_m in enumerate(place_m):
                across_m = abs(antenna_m - x_m)
                best = np.argmin(np.abs(across_m - reach_m))
                air_m = height_m / math.cos(pairs[best][0])
                soil_m = depth_m / math.cos(pairs[best][1])
                delay_s = 2.0 * (air_m + root * soil_m) / SPEED_M_S
                n = min(round(delay_s / sample_s), last)
                weight = math.cos(pairs[best][0]) / math.sqrt(air_m + soil_m + 1e-9)
                values.append(weight * gain[n] * a_scans[trace, n])
            steps = zip(values, values[1:], np.diff(place_m))
            image[row, column] = abs(sum(0.5 * (a + b) * step for a, b, step in steps))
    return image


@pytest.mark.parametrize(("seed", "sweep"), list(enumerate(SWEEPS)))
def test_the_image_is_that_of_the_published_algorithm(seed, sweep):
    random = np.random.default_rng(seed)
    start_mhz, stop_mhz, count, zeros, dropped, sample_ps = sweep
    permittivity, x_mm, y_mm = random.uniform(3, 9), 60 + 20.0 * np.arange(9), 20.0 * np.arange(7)
    targets = [
        point(*random.uniform((80, 20), (200, 100)), random.uniform(0.04, 0.2)) for _ in range(3)
    ]
    frequency_hz = np.linspace(start_mhz * 1e6, stop_mhz * 1e6, count)
    survey = survey_of(
        scene(targets, permittivity, noise_db=-80.0, height_m=random.uniform(0.15, 0.3)),
        *(x_mm, y_mm, frequency_hz, (0.0,)),
    )
    survey["height"] = survey.height + random.normal(0.0, 0.002, survey.height.shape)
    cleaned = remove_background(survey, Background.MEAN)
    images = [
        image_survey(cleaned, ImageOptions(method, permittivity, (0.0, LAST_M)))
        for method in (KIRCHHOFF, KIRCHHOFF_2D)
    ]
    depths_m = np.arange(0.0, LAST_M, sample_ps * 1e-12 * SPEED_M_S / math.sqrt(permittivity))
    np.testing.assert_allclose(images[0].depth, depths_m, rtol=1e-5)
    a_scans = published_a_scans(survey.s21.values[0], zeros, dropped)
    shared = (depths_m, float(survey.height.mean()), permittivity, sample_ps * 1e-12)
    along_x = np.stack([published_line(row, x_mm / 1e3, *shared) for row in a_scans], axis=1)
    along_y = [published_line(row, y_mm / 1e3, *shared) for row in np.swapaxes(a_scans, 0, 1)]
    product = along_x * np.stack(along_y, axis=2)
    assert correlation(images[0].image.values[0], product) > 0.999
    assert correlation(images[1].image.values[0], along_x) > 0.999
    assert ("too shallow" in " ".join(images[0].attrs["notes"])) is (dropped > 0)


def test_what_the_method_cannot_image_is_refused():
    for fault, options in (
        (NOT_ALLOWED, {"grid_step_m": 0.01}),
        (NOT_ALLOWED, {"ground": Ground.UNEVEN}),
    ):
        with raises_fault(fault):
            ImageOptions(KIRCHHOFF_2D, 4.0, **options)
    x_mm = np.array([0.0, 20.0, 47.0, 60.0])
    survey = survey_of(scene([]), x_mm, x_mm, np.linspace(6e8, 6e9, 51), (0.0,))
    with raises_fault(NOT_ALLOWED):
        image_survey(survey, ImageOptions(KIRCHHOFF, 4.0))
    line = survey_of(scene([]), np.arange(9) * 20.0, [0.0], np.linspace(6e8, 6e9, 51), (0.0,))
    with raises_fault(NOT_ALLOWED, "1 position along y"):
        image_survey(line, ImageOptions(KIRCHHOFF, 4.0))


@pytest.mark.parametrize("method", [KIRCHHOFF, KIRCHHOFF_2D])
def test_candidates_lie_where_they_are_within_their_uncertainties(method):
    assert errors_in_uncertainties(method).max() < 1.6
