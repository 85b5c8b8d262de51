"""The noise of an image is that of its data, whatever the picture shows, by every method."""

from __future__ import annotations

import os

import numpy as np
import pytest
import xarray as xr

from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.dataset import NOISE, S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.noise import Law, law_of
from gpr20_analysis.processing.background import remove_background
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.results.candidates import Flag

pytestmark = pytest.mark.takes(30)

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


@pytest.mark.parametrize("law", Law)
def test_the_tail_of_each_law_is_that_of_drawn_noise(law):
    random = np.random.default_rng(1)
    first, second = np.abs(random.standard_normal((2, 400_000)))
    drawn = {
        Law.RAYLEIGH: np.abs(noise(random, (400_000,))),
        Law.HALF_NORMAL: first,
        Law.PRODUCT: first * second,
    }[law]
    assert np.mean(np.log(drawn)) == pytest.approx(law.mean_log, abs=0.01)
    assert np.median(drawn) == pytest.approx(law.median, rel=0.01)
    for share in (0.5, 0.1, 0.01, 0.001):
        level = law.ratio_at(np.log(share))
        assert np.mean(drawn > level) == pytest.approx(share, rel=0.15)
        assert np.exp(law.log_tail(np.asarray(level))) == pytest.approx(share, rel=1e-3)


@pytest.mark.parametrize("method", Method)
def test_noise_alone_is_at_0_db_and_leads_to_candidates_as_often_as_the_rate_says(method):
    """Half of the images of noise have a voxel that noise exceeds in half of the images."""
    law = law_of(method.value)
    count, found = 0, []
    for seed in range(SURVEYS):
        random, level = np.random.default_rng(100 + seed), (1e-6, 1.0)[seed % 2]
        image = imaged(survey(random, level, rotations=(0.0,)), method)
        count += bool(find_candidates(image, CandidateOptions(0.5)).candidates)
        assert not find_candidates(image, CandidateOptions(1e-5)).candidates
        over = image.noise_over_y.values[:, None] * image.noise_over_x.values
        ratio = np.abs(image.image.values) / (image[NOISE].values[..., None, None] * over)
        found.append(np.mean(np.log(ratio)) - law.mean_log)
    assert 0.1 < count / SURVEYS < 0.9
    for of_one_level in (found[::2], found[1::2]):
        assert abs(float(law.level_db(np.exp(np.mean(of_one_level))))) < 0.4


@pytest.mark.parametrize(("seed", "method"), [(0, Method.PHASE_SHIFT), (1, Method.BACK_PROJECTION)])
def test_the_level_above_noise_does_not_depend_on_the_depths_shown(seed, method):
    random = np.random.default_rng(seed)
    depth_m = float(random.uniform(0.05, 0.09))
    place = tuple(random.uniform(0.07, 0.14, 2))
    data = survey(random, 1.0, [(*place, depth_m)])
    levels = []
    for last_m in (0.12, 0.2, 0.3):
        image = imaged(data, method, tuple(np.arange(0.0, last_m, 0.004)))
        levels.append(find_candidates(image).candidates[0].above_noise_db)
    assert np.ptp(levels) < 0.5
    # A target fills more of a shallow picture, which must not hide it.
    shallow = imaged(data, method, tuple(np.arange(depth_m - 0.01, depth_m + 0.01, 0.002)))
    assert abs(find_candidates(shallow).candidates[0].above_noise_db - levels[0]) < 0.5


def test_a_late_echo_is_not_taken_for_noise():
    random = np.random.default_rng(3)
    data = survey(random, points=301)
    quiet = imaged(data)[NOISE].values
    # As at the end of a long cable: at 40 of 56 ns.
    late = 30.0 * np.exp(-2j * np.pi * data.frequency * 40e-9)
    loud = image_survey(data.assign(s21=data.s21 + late), ImageOptions(permittivity=4.0))
    assert np.max(np.abs(20.0 * np.log10(loud[NOISE].values.mean() / quiet.mean()))) < 1.0


def test_with_too_few_frequencies_every_candidate_is_unrated_and_a_note_says_why():
    data = survey(np.random.default_rng(2), 0.01, [(0.1, 0.1, 0.08)], points=41)
    image = imaged(data)
    assert NOISE not in image
    found = find_candidates(image)
    assert found.candidates and all(Flag.UNRATED in one.flags for one in found.candidates)
    assert all(np.isnan(one.above_noise_db) for one in found.candidates)
    assert any("noise could not be measured" in str(note) for note in found.notes)


@pytest.mark.parametrize("method", Method)
def test_candidates_lie_where_they_are_within_their_uncertainties(method):
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
    assert np.sqrt(np.mean(np.square(errors), axis=0)).max() < 1.6


@pytest.mark.parametrize("method", [Method.KIRCHHOFF, Method.KIRCHHOFF_2D])
def test_the_noise_over_depth_follows_the_gain_of_the_group_in_wet_soil(method):
    law, parts = law_of(method.value), []
    for seed in range(3):
        data = remove_background(survey(np.random.default_rng(seed), points=161))
        image = image_survey(data, ImageOptions(method, 9.0, DEPTH_M))
        over = image.noise_over_y.values[:, None] * image.noise_over_x.values
        ratio = np.abs(image.image.values) / (image[NOISE].values[..., None, None] * over)
        third = ratio.shape[1] // 3
        parts.append([np.mean(np.log(ratio[:, part])) for part in np.s_[:third, -third:]])
    shallow_db, deep_db = law.level_db(np.exp(np.mean(parts, axis=0) - law.mean_log))
    assert abs(shallow_db - deep_db) < 1.2
