"""The noise of an image is that of its data, whatever the picture shows, by every method."""

from __future__ import annotations

import numpy as np
import pytest
from noise_kit import (
    errors_in_uncertainties,
    imaged,
    noise,
    noise_level_db,
    share_of_alarms,
    survey,
)

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import NOISE
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.noise import Law
from gpr20_survey.results.candidates import Flag

METHODS = [Method.PHASE_SHIFT, Method.BACK_PROJECTION]


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


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("level", [1e-6, 1.0])
def test_noise_alone_is_at_0_db_by_every_method(method, level):
    assert abs(noise_level_db(method, level)) < 0.4


@pytest.mark.parametrize("method", METHODS)
def test_noise_alone_leads_to_candidates_as_often_as_the_rate_says(method):
    assert 0.1 < share_of_alarms(method) < 0.9


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


@pytest.mark.parametrize("method", METHODS)
def test_candidates_lie_where_they_are_within_their_uncertainties(method):
    assert errors_in_uncertainties(method).max() < 1.6
