"""The images against point scatterers whose place is known, all of them off the grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import GRID_MM, point, scene, survey_of
from scipy.constants import speed_of_light

from gpr20_analysis import faults
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.a_scans import gated_sweep
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_simulator.mid.world.ground import Ground as SimulatedGround
from gpr20_simulator.mid.world.scene import Surface
from gpr20_survey.radar.refraction import one_way_delay_s

TARGETS = (point(173.3, 181.7, 0.1134), point(318.9, 307.4, 0.0711))
QUIET = {"coupling_level_db": -200.0, "surface_gain_db": -200.0}
EXACT = (Method.PHASE_SHIFT, Method.BACK_PROJECTION)


def brightest_near(image, target, turn=0):
    """Return the bright candidate of one polarization nearest to a target."""
    found = find_candidates(image.isel(polarization=[turn])).candidates
    return min(
        (one for one in found if one.above_clutter_db > found[0].above_clutter_db - 15.0),
        key=lambda one: np.hypot(one.x_m - target.x_mm / 1e3, one.y_m - target.y_mm / 1e3),
    )


def error_mm(echo, target):
    return np.array(
        [
            echo.x_m * 1e3 - target.x_mm,
            echo.y_m * 1e3 - target.y_mm,
            (echo.depth_m - target.depth_m) * 1e3,
        ]
    )


@pytest.fixture(scope="module")
def survey():
    return survey_of(scene(TARGETS, **QUIET), rotations_deg=(0.0,))


@pytest.mark.parametrize("method", EXACT)
@pytest.mark.parametrize("permittivity", [2.0, 9.0])
def test_point_targets_are_where_the_scene_has_them(method, permittivity):
    survey = survey_of(scene(TARGETS, permittivity), rotations_deg=(0.0,))
    cleaned = remove_background(survey)
    image = image_survey(cleaned, ImageOptions(method, permittivity))
    for target in TARGETS:
        assert np.all(np.abs(error_mm(brightest_near(image, target), target)) < 2.0)


def test_phase_shift_and_back_projection_agree(survey):
    images = [image_survey(survey, ImageOptions(method, 4.0)).image.values for method in EXACT]
    products = [np.vdot(a, b) for a, b in ((images[0], images[1]), *((i, i) for i in images))]
    assert abs(products[0]) / np.sqrt(abs(products[1] * products[2])) > 0.85


@pytest.mark.parametrize("method", EXACT)
def test_wrong_permittivity_moves_depth_as_theory_says(survey, method):
    image = image_survey(survey, ImageOptions(method, 5.0))
    target = TARGETS[0]
    moved = brightest_near(image, target).depth_m
    # Straight below, delay and so depth times the root of the permittivity stay.
    assert moved == pytest.approx(target.depth_m * np.sqrt(4.0 / 5.0), abs=0.006)


@pytest.mark.parametrize("method", EXACT)
def test_wrong_height_moves_depth_upwards(survey, method):
    image = image_survey(survey, ImageOptions(method, 4.0, height_m=0.21))
    assert brightest_near(image, TARGETS[0]).depth_m < TARGETS[0].depth_m - 0.003


@pytest.mark.parametrize("method", EXACT)
def test_shuffled_traces_give_no_focus(survey, method):
    order = np.random.default_rng(1).permutation(GRID_MM.size**2)
    mixed = survey.s21.values.reshape(1, -1, survey.sizes["frequency"])[:, order]
    shuffled = survey.assign(s21=(survey.s21.dims, mixed.reshape(survey.s21.shape)))
    sharp, blurred = (
        np.abs(image_survey(one, ImageOptions(method, 4.0)).image.values)
        for one in (survey, shuffled)
    )
    assert sharp.max() > 3.0 * blurred.max()


@pytest.mark.parametrize("method", EXACT)
def test_recorded_heights_undo_a_tilted_scanner(method):
    def height_m(x_mm, y_mm):
        return 0.2 + 0.04 * (x_mm - 240.0) / 360.0

    survey = survey_of(scene(TARGETS, **QUIET), rotations_deg=(0.0,), height_m=height_m)
    recorded = image_survey(survey, ImageOptions(method, 4.0, ground=Ground.LEVEL))
    mean = image_survey(survey, ImageOptions(method, 4.0, height_m=0.2))
    for target in TARGETS:
        assert np.linalg.norm(error_mm(brightest_near(recorded, target), target)) < 1.5
        assert np.linalg.norm(error_mm(brightest_near(mean, target), target)) > 10.0


@pytest.mark.parametrize(
    ("surface", "separation_m"),
    [(Surface(slope_x=0.03), 0.06), (Surface(slope_y=-0.03, wave_amplitude_m=0.003), 0.0)],
)
def test_targets_below_uneven_ground_are_found_where_they_are(surface, separation_m):
    uneven = replace(scene(TARGETS, separation_m=separation_m, **QUIET), surface=surface)
    survey = survey_of(uneven, rotations_deg=(0.0,))
    options = ImageOptions(Method.BACK_PROJECTION, 4.0, separation_m=separation_m)
    known = image_survey(survey, replace(options, ground=Ground.UNEVEN))
    taken_as_level = image_survey(survey, options)
    for target in TARGETS:
        above_m = SimulatedGround(uneven).surface_height_m(target.x_mm, target.y_mm)
        below_surface = replace(target, depth_m=target.depth_m + above_m)
        assert np.linalg.norm(error_mm(brightest_near(known, target), below_surface)) < 2.0
        assert np.linalg.norm(error_mm(brightest_near(taken_as_level, target), below_surface)) > 4.0


def test_noise_of_the_recorded_heights_moves_echoes_below_uneven_ground_little():
    uneven = replace(scene(TARGETS, **QUIET), surface=Surface(slope_x=0.03))
    survey = survey_of(uneven, rotations_deg=(0.0,))
    noise_m = 0.004 * np.random.default_rng(5).standard_normal(survey.height.shape)
    options = ImageOptions(Method.BACK_PROJECTION, 4.0, ground=Ground.UNEVEN)
    image = image_survey(survey.assign(height=survey.height + noise_m), options)
    for target in TARGETS:
        above_m = SimulatedGround(uneven).surface_height_m(target.x_mm, target.y_mm)
        below_surface = replace(target, depth_m=target.depth_m + above_m)
        assert np.linalg.norm(error_mm(brightest_near(image, target), below_surface)) < 4.0


def test_level_ground_is_the_same_by_either_way(survey):
    options = ImageOptions(Method.BACK_PROJECTION, 4.0)
    level = image_survey(survey, options).image.values
    uneven = image_survey(survey, replace(options, ground=Ground.UNEVEN)).image.values
    assert np.allclose(uneven, level, atol=1e-5 * np.abs(level).max())


def test_uneven_ground_is_refused_by_a_method_that_takes_it_as_level():
    with raises_fault(faults.METHOD, "needs --method back-projection"):
        ImageOptions(Method.PHASE_SHIFT, 4.0, ground=Ground.UNEVEN)


def test_heights_that_differ_much_are_told_with_an_image_of_level_ground(survey):
    def height_m(x_mm, y_mm):
        return 0.2 + 0.02 * (x_mm - 240.0) / 360.0

    tilted = survey_of(scene(TARGETS, **QUIET), rotations_deg=(0.0,), height_m=height_m)
    options = ImageOptions(Method.BACK_PROJECTION, 4.0)
    assert "differ by 20 mm" in " ".join(image_survey(tilted, options).attrs["notes"])
    assert image_survey(survey, options).attrs["notes"] == []


def test_antennas_apart_are_focused_by_back_projection():
    target = point(243.7, 236.2, 0.06)
    survey = survey_of(scene([target], separation_m=0.12, **QUIET))
    apart = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0, separation_m=0.12))
    together = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0))
    assert np.linalg.norm(error_mm(brightest_near(apart, target), target)) < 1.5
    assert abs(error_mm(brightest_near(together, target), target)[2]) > 3.0


def test_irregular_positions_are_refused_by_the_fast_method_and_imaged_by_the_other():
    places = GRID_MM + np.where(np.arange(GRID_MM.size) % 2, 4.0, 0.0)
    survey = survey_of(scene(TARGETS, **QUIET), x_mm=places, rotations_deg=(0.0,))
    with raises_fault(faults.METHOD):
        image_survey(survey, ImageOptions(Method.PHASE_SHIFT, 4.0))
    image = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0))
    assert np.linalg.norm(error_mm(brightest_near(image, TARGETS[0]), TARGETS[0])) < 2.0


def test_gating_keeps_an_echo_within_and_drops_one_beyond():
    sweep = FrequencyGrid(6e8, 10.8e6, 501)
    window = np.hanning(501)
    within, beyond = (np.exp(-2j * np.pi * sweep.frequency_hz * t) * window for t in (6e-9, 25e-9))
    coarse, matrix = gated_sweep(sweep, 12e-9)
    assert coarse.count < 100
    kept = np.interp(coarse.frequency_hz, sweep.frequency_hz, window)
    np.testing.assert_allclose(np.abs(within @ matrix), kept, atol=0.01)
    assert np.max(np.abs(beyond @ matrix)) < 0.01


def test_a_gate_longer_than_the_sweep_changes_nothing():
    sweep = FrequencyGrid(6e8, 54e6, 101)
    same, matrix = gated_sweep(sweep, 20e-9)
    assert same == sweep
    np.testing.assert_array_equal(matrix, np.eye(101))


def test_a_wave_without_soil_goes_straight():
    delay_s = one_way_delay_s(0.2, 0.15, 0.6, 1.0)
    assert delay_s == pytest.approx(np.hypot(0.35, 0.6) / speed_of_light, rel=1e-12)
