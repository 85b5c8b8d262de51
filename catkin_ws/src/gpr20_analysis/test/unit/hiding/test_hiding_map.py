"""The map of where a target could hide, from whole surveys."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from recorded_worlds import BORN, area, truths

from gpr20_analysis import faults
from gpr20_analysis.hiding.detector import Detector, Searched, is_found
from gpr20_analysis.hiding.injection import with_targets
from gpr20_analysis.hiding.runs import HidingOptions, Runs
from gpr20_analysis.hiding.scattering import Soil, echo_of
from gpr20_analysis.hiding.search import map_hidden
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS, Method, imaging_method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey
from gpr20_survey.results.hidden_target import Target, Targets

SMALL = HidingOptions((0.03, 0.15), rounds=6, loss_tangent=0.0)
DISC = Targets.TYPE_72.value


def detector(permittivity=4.0, method=Method.PHASE_SHIFT):
    options = ImageOptions(
        permittivity=permittivity,
        permittivity_uncertainty=0.05,
        ground=Ground.LEVEL,
        method=method,
    )
    return Detector(lambda survey: process_survey(survey, *DEFAULT_STEPS), options)


@pytest.fixture(scope="module")
def ground():
    """Level ground with one body, and noise that hides what is faint."""
    return survey_of(scene([point(330.0, 330.0, 0.08, 0.02)], noise_db=-75.0))


@pytest.fixture(scope="module")
def found(ground):
    return map_hidden(ground, detector(), DISC, SMALL)


def test_a_shallow_disc_is_found_and_none_that_noise_hides(ground, found):
    assert np.nanmedian(found.share[0]) > 0.8
    noisy = ground.assign(s21=ground["s21"] + noise(ground, 0.5))
    hidden = map_hidden(noisy, detector(), DISC, SMALL)
    assert hidden.found.sum() < 0.5 * found.found.sum()
    assert np.isfinite(hidden.missed_m).mean() > np.isfinite(found.missed_m).mean()


def noise(survey, level):
    """Return white noise, by its level relative to the largest value."""
    random = np.random.default_rng(5)
    parts = random.standard_normal((*survey["s21"].shape, 2)) @ np.array([1.0, 1j])
    return survey["s21"].copy(data=level * np.abs(survey["s21"]).max().item() * parts)


def test_a_faint_target_is_found_less_often_than_a_bright_one(ground):
    shares = [
        np.nansum(map_hidden(ground, detector(), target, SMALL).found)
        for target in (Target("faint", 0.03, 0.01, 3.99), DISC)
    ]
    assert shares[0] < 0.5 * shares[1]


def test_the_same_seed_gives_the_same_map_and_another_seed_an_alike_one(ground, found):
    again = map_hidden(ground, detector(), DISC, SMALL)
    assert np.array_equal(again.found, found.found) and np.array_equal(again.tried, found.tried)
    other = map_hidden(
        ground, detector(), DISC, HidingOptions(SMALL.depth_m, 6, loss_tangent=0.0, seed=7)
    )
    assert not np.array_equal(other.tried, found.tried)
    apart = (other.lowest > found.highest) | (found.lowest > other.highest)
    assert apart.mean() < 0.15


def test_the_map_says_what_it_was_made_of(found):
    assert found.target == DISC
    assert found.permittivity_range == pytest.approx((3.8, 4.2))
    assert "permittivity of the soil: as given" in map(str, found.notes)
    assert (found.tried > 0).all()
    assert np.all((found.lowest <= found.share) & (found.share <= found.highest))
    assert found.checked > 0 and 0 <= found.agreed <= found.checked


@pytest.mark.parametrize(
    "number", [0, *(pytest.param(one, marks=pytest.mark.release) for one in (3, 6, 9))]
)
def test_one_target_is_found_as_the_whole_detector_finds_it(number):
    """Fields that the imaging did not make; 12 random places in each."""
    survey, truth = area(BORN, number)
    assert truths(BORN)[number] == truth
    own = detector(truth["permittivity"])
    searched = Searched(survey, own)
    options = HidingOptions((0.05, 0.17), rounds=6, separation_m=0.06, loss_tangent=0.02)
    runs = Runs(survey, searched, own, DISC, options, None)
    alike = []
    for depth_m in options.depth_m:
        runs.left[depth_m] = runs.left_by(depth_m)
        for one in range(options.rounds):
            answers = dict(runs.added((depth_m, one)))
            alike += [answers[place_m] == is_it for place_m, is_it in runs.whole((depth_m, one))]
    assert len(alike) >= 10
    assert sum(alike) >= 0.8 * len(alike)


def test_what_changes_nothing_was_not_found(ground):
    searched = detector().search(ground)
    nothing = replace(searched, candidates=())
    body = next(one for one in searched.candidates if not one.is_doubtful)
    place_m = (body.x_m, body.y_m)
    assert is_found(searched, nothing, place_m, body.depth_m, DISC)
    assert not is_found(searched, searched, place_m, body.depth_m, DISC)
    assert not is_found(searched, nothing, (body.x_m + 0.2, body.y_m), body.depth_m, DISC)
    assert not is_found(searched, nothing, place_m, body.depth_m + 0.1, DISC)


@pytest.mark.parametrize(
    "permittivity",
    [4.0, *(pytest.param(one, marks=pytest.mark.release) for one in (4.0 + 1e-9, 3.95))],
)
def test_a_target_like_the_soil_is_found_nowhere(ground, permittivity):
    target = Target("soil", 0.08, 0.01, permittivity)
    options = ImageOptions(permittivity=4.0, permittivity_uncertainty=0.01, ground=Ground.LEVEL)
    own = Detector(lambda survey: process_survey(survey, *DEFAULT_STEPS), options)
    found = map_hidden(ground, own, target, SMALL)
    assert found.missed.all()


def test_where_the_permittivity_may_be_that_of_the_target_it_could_hide(ground):
    unknown = Detector(
        lambda survey: process_survey(survey, *DEFAULT_STEPS), ImageOptions(ground=Ground.LEVEL)
    )
    found = map_hidden(ground, unknown, DISC, HidingOptions((0.03,), rounds=8, loss_tangent=0.0))
    assert found.missed.all()
    assert any("invisible" in str(one) for one in found.details)


def test_traces_that_received_nothing_get_no_echo(ground):
    dead = ground.copy(deep=True)
    dead["s21"].values[:, :, 13:] = 1e-3 * noise(ground, 1e-3).values[:, :, 13:]
    echo = echo_of(DISC, 0.05, Soil(4.0), 0.2, ground["frequency"].values, 0.6)
    transmission = np.ones((2, ground.sizes["frequency"]))
    injected = with_targets(dead, echo, [(0.25, 0.25)], 4.0, transmission, 0.0)
    changed = np.any(injected["s21"].values != dead["s21"].values, axis=-1)
    assert changed[:, :, :13].all() and not changed[:, :, 13:].any()


def test_a_line_has_a_map_along_it(ground):
    line = survey_of(
        scene([point(700.0, 0.0, 0.08)], noise_db=-75.0),
        np.linspace(0.0, 1500.0, 76),
        np.array([0.0]),
        rotations_deg=(0.0,),
    )
    found = map_hidden(line, detector(), DISC, SMALL)
    assert found.missed_m.shape[0] == 1 < found.missed_m.shape[1]
    assert np.nansum(found.found) > 0


def test_changed_data_and_methods_that_are_no_sums_are_refused(ground):
    changed = process_survey(ground, *DEFAULT_STEPS)
    with raises_fault(faults.STEPS):
        map_hidden(changed, detector(), DISC, SMALL)
    squared = replace(imaging_method("phase-shift"), name="squared", is_linear=False)
    with raises_fault(faults.METHOD):
        map_hidden(ground, detector(method=squared), DISC, SMALL)


@pytest.mark.parametrize(
    "wrong",
    [
        {"depth_m": ()},
        {"depth_m": (0.1, 0.1)},
        {"depth_m": (0.1, float("nan"))},
        {"depth_m": (-0.1, 0.1)},
        {"depth_m": (0.1, 1.1)},
        {"rounds": 0},
        {"needed": 0.0},
        {"needed": float("nan")},
        {"loss_tangent": -0.1},
        {"seed": -1},
    ],
)
def test_options_that_are_not_allowed_are_refused(wrong):
    with raises_fault(faults.OPTION):
        HidingOptions(**wrong)


def test_heights_without_a_surface_echo_need_a_model(ground):
    no_surface = ground.assign(s21=noise(ground, 1.0))
    with raises_fault(faults.NO_SURFACE_ECHO):
        map_hidden(no_surface, detector(), DISC, SMALL)


def test_antennas_near_the_ground_need_a_model(ground):
    near = survey_of(scene([point(240.0, 240.0, 0.08)], height_m=0.03))
    with raises_fault(faults.NO_SURFACE_ECHO):
        map_hidden(near, detector(), DISC, SMALL)
