"""The estimate of the permittivity, and its honesty."""

from __future__ import annotations

import os
from itertools import product

import numpy as np
import pytest
from fault_kit import raises_fault
from fermat_kit import Body, Buried, Setup, noise, reflection_m, s21_of
from fermat_kit import survey_of as survey_of_echoes
from ground_kit import IMAGING_SCENE, point, scene, survey_of
from random_scenes_kit import Clutter, random_noise, random_scene
from scipy.constants import speed_of_light

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_output import permittivity_line
from gpr20_analysis.imaging.image_traces import traces_of
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.permittivity.permittivity_estimate import (
    PermittivityEstimate,
    estimate_permittivity,
)
from gpr20_analysis.imaging.permittivity.wavefront import Stops, wavefront
from gpr20_analysis.imaging.records import Focus
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.sentences import sentences_of

# A larger draw: GPR20_SCENES=100.
SCENES = int(os.environ.get("GPR20_SCENES", "2"))
ALLOWED = 0.05
PLACE_M = np.arange(0.0, 0.4501, 0.015)
FREQUENCY_HZ = np.linspace(600e6, 6e9, 101)


def setup(x_m=PLACE_M, y_m=PLACE_M, height_m=0.12, separation_m=0.0, rotations_deg=(0.0,)):
    heights_m = np.full((len(y_m), len(x_m)), height_m)
    return Setup(x_m, y_m, heights_m, FREQUENCY_HZ, separation_m, rotations_deg)


def survey_over(bodies, permittivity, where=None, snr_db=20.0, seed=1):
    where = where or setup()
    s21 = s21_of(bodies, permittivity, where)
    level = np.abs(s21).max() * 10.0 ** (-snr_db / 20.0)
    return survey_of_echoes(s21 + level * noise(np.random.default_rng(seed), s21.shape), where)


def estimate(survey, separation_m=0.0) -> PermittivityEstimate:
    options = ImageOptions(separation_m=separation_m)
    traces, _ = traces_of(remove_background(survey), options)
    focus = Focus(4.0, np.asarray(options.depth_m), separation_m=separation_m)
    return estimate_permittivity(traces, focus)


def test_delays_of_a_sphere_are_those_of_fermats_principle():
    x_m, y_m = np.meshgrid(np.linspace(-0.4, 0.4, 7), np.linspace(-0.3, 0.3, 5))
    height_m = np.full(x_m.shape, 0.15)
    for separation_m, radius_m in product((0.0, 0.15), (0.0, 0.02, 0.06)):
        offset_m = (0.3 * separation_m, 0.4 * separation_m)
        antennas_m = [
            np.stack([x_m + side * offset_m[0], y_m + side * offset_m[1], height_m], -1)
            for side in (1.0, -1.0)
        ]
        sphere = Buried(Body.SPHERE, 0.03, -0.02, 0.08, radius_m)
        expected_m = reflection_m(antennas_m, sphere, 5.0)
        stops = Stops(x_m, y_m, height_m, offset_m)
        found = wavefront(stops, (0.03, -0.02), 0.08 * np.sqrt(5.0), 5.0, radius_m)
        np.testing.assert_allclose(found.delay_s * speed_of_light, expected_m, atol=5e-4)


@pytest.mark.parametrize("radius_m", [0.02, 0.04])
def test_the_size_of_a_sphere_does_not_lower_the_permittivity(radius_m):
    found = estimate(survey_over([Buried(Body.SPHERE, 0.22, 0.23, 0.12, radius_m)], 4.0))
    assert found.lowest < 4.0 < found.highest


def test_antennas_apart_do_not_change_the_permittivity():
    separation_m = 0.12
    where = setup(separation_m=separation_m, rotations_deg=(0.0, 90.0))
    bodies = [Buried(Body.POINT, 0.22, 0.23, 0.15), Buried(Body.SPHERE, 0.1, 0.33, 0.12, 0.03)]
    found = estimate(survey_over(bodies, 4.0, where), separation_m)
    assert found.lowest < 4.0 < found.highest


@pytest.mark.parametrize("permittivity", [3.0, 12.0])
def test_small_deep_bodies_tell_the_permittivity(permittivity):
    bodies = [Buried(Body.POINT, 0.15, 0.17, 0.16), Buried(Body.POINT, 0.31, 0.28, 0.13)]
    found = estimate(survey_over(bodies, permittivity))
    assert found.lowest < permittivity < found.highest
    assert found.highest < 1.8 * found.lowest
    assert found.permittivity == pytest.approx(permittivity, rel=0.2)


def test_one_line_is_enough_and_says_what_it_assumes():
    where = setup(np.arange(0.0, 0.6, 0.01), np.array([0.2]), 0.08)
    line = survey_over([Buried(Body.POINT, 0.3, 0.2, 0.2)], 6.0, where)
    image = image_survey(remove_background(line), ImageOptions(Method.BACK_PROJECTION))
    assert image.attrs["permittivity_lowest"] < 6.0 < image.attrs["permittivity_highest"]
    assert "single line" in " ".join(str(one) for one in sentences_of(image, "notes"))


def test_uneven_spacing_is_no_obstacle():
    random = np.random.default_rng(0)
    x_m, y_m = (np.sort(random.uniform(0.0, 0.45, 28)) for _ in range(2))
    bodies = [Buried(Body.POINT, 0.2, 0.25, 0.17), Buried(Body.SPHERE, 0.3, 0.15, 0.12, 0.02)]
    found = estimate(survey_over(bodies, 7.0, setup(x_m, y_m)))
    assert found.lowest < 7.0 < found.highest


def test_random_scenes_are_within_the_range_or_refused():
    held = refused = 0
    for seed in range(SCENES):
        drawn = random_scene(1000 + seed)
        try:
            found = estimate(drawn.survey, drawn.separation_m)
        except WrongDatasetError:
            refused += 1
            continue
        held += found.lowest <= drawn.permittivity <= found.highest
    assert held >= (SCENES - refused) * (1.0 - ALLOWED)
    assert refused < 0.7 * SCENES


@pytest.mark.parametrize("kind", Clutter.ALL)
def test_noise_is_refused_with_advice(kind):
    for seed in range(SCENES):
        with raises_fault(faults.NO_PERMITTIVITY):
            estimate(random_noise(500 + seed, kind))


def test_a_long_body_is_not_taken_for_a_compact_one():
    long = Buried(Body.CYLINDER, 0.22, 0.23, 0.1, 0.02, length_m=0.3, direction_rad=0.4)
    with raises_fault(faults.NO_PERMITTIVITY):
        estimate(survey_over([long], 5.0))


def test_a_body_that_leaves_much_open_is_refused():
    # High antennas and a shallow body: refraction hardly changes the delays.
    shallow = Buried(Body.POINT, 0.22, 0.23, 0.05)
    with raises_fault(faults.NO_PERMITTIVITY):
        estimate(survey_over([shallow], 5.0, setup(height_m=0.4), snr_db=0.0))


def test_extended_targets_of_the_simulated_robot_are_within_the_range():
    image = image_survey(remove_background(survey_of(IMAGING_SCENE)), ImageOptions())
    assert image.attrs["permittivity_lowest"] < 5.0 < image.attrs["permittivity_highest"]
    assert "ESTIMATED" in str(permittivity_line(image))


def test_nothing_to_focus_is_refused():
    survey = survey_of(scene([point(240.0, 240.0, 0.1)]), rotations_deg=(0.0,))
    empty = survey.assign(s21=survey.s21 * 0.0)
    with raises_fault(faults.NO_SAMPLES):
        image_survey(empty, ImageOptions())


def test_given_permittivity_is_not_called_estimated():
    points = [point(173.3, 181.7, 0.113)]
    survey = survey_of(scene(points), np.linspace(100, 300, 9), np.linspace(100, 300, 9))
    image = image_survey(survey, ImageOptions(permittivity=4.0))
    assert image.attrs["permittivity_source"] == "given"
    assert "as given" in str(permittivity_line(image))
    assert np.isclose(image.attrs["permittivity"], 4.0)
