"""The images against point scatterers whose place is known, all of them off the grid."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from hypothesis import given
from hypothesis import strategies as st
from scipy.constants import speed_of_light

from gpr20_analysis import faults, lazy
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.background import remove_background
from gpr20_simulator.mid.world.ground import Ground as SimulatedGround
from gpr20_simulator.mid.world.refraction import refracted_path
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
@pytest.mark.parametrize("permittivity", [2.0, pytest.param(9.0, marks=pytest.mark.release)])
def test_point_targets_are_where_the_scene_has_them(method, permittivity):
    survey = survey_of(scene(TARGETS, permittivity), rotations_deg=(0.0,))
    cleaned = remove_background(survey)
    image = image_survey(cleaned, ImageOptions(method, permittivity))
    for target in TARGETS:
        assert np.all(np.abs(error_mm(brightest_near(image, target), target)) < 2.0)


def test_phase_shift_and_back_projection_agree(survey):
    images = [image_survey(survey, ImageOptions(method, 4.0)).image.values for method in EXACT]
    with raises_fault(faults.METHOD, "needs --method back-projection"):
        ImageOptions(Method.PHASE_SHIFT, 4.0, ground=Ground.UNEVEN)
    # Level ground is the same by either way.
    options = ImageOptions(Method.BACK_PROJECTION, 4.0, ground=Ground.UNEVEN)
    uneven = image_survey(survey, options).image.values
    assert np.allclose(uneven, images[1], atol=1e-5 * np.abs(images[1]).max())
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
def test_recorded_heights_undo_a_tilted_scanner(method):
    def height_m(x_mm, y_mm):
        return 0.2 + 0.04 * (x_mm - 240.0) / 360.0

    survey = survey_of(scene(TARGETS, **QUIET), rotations_deg=(0.0,), height_m=height_m)
    recorded = image_survey(survey, ImageOptions(method, 4.0, ground=Ground.LEVEL))
    noted = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0)).attrs["notes"]
    assert any("differ by 40 mm" in one for one in noted)
    mean = image_survey(survey, ImageOptions(method, 4.0, height_m=0.2))
    for target in TARGETS:
        assert np.linalg.norm(error_mm(brightest_near(recorded, target), target)) < 1.5
        assert np.linalg.norm(error_mm(brightest_near(mean, target), target)) > 10.0


@pytest.mark.parametrize(
    ("surface", "separation_m"),
    [
        (Surface(slope_y=-0.03, wave_amplitude_m=0.003), 0.0),
        pytest.param(Surface(slope_x=0.03), 0.06, marks=pytest.mark.release),
    ],
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


def test_antennas_apart_are_focused_by_back_projection():
    target = point(243.7, 236.2, 0.06)
    survey = survey_of(scene([target], separation_m=0.12, **QUIET))
    apart = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0, separation_m=0.12))
    together = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0))
    assert np.linalg.norm(error_mm(brightest_near(apart, target), target)) < 1.5
    assert abs(error_mm(brightest_near(together, target), target)[2]) > 3.0


X_MM, Y_MM = np.linspace(60.0, 360.0, 21), np.linspace(90.0, 330.0, 17)
DEPTH_M = tuple(np.arange(0.04, 0.16, 0.004))


def survey_with(target, x_mm=X_MM, y_mm=Y_MM):
    return survey_of(scene([target], **QUIET), x_mm, y_mm, rotations_deg=(0.0,))


def imaged(survey, method, step_m):
    return image_survey(survey, ImageOptions(method, 4.0, DEPTH_M, grid_step_m=step_m))


def brightest_voxel_error_mm(image, target):
    level = abs(image.image[0])
    place = level.where(level == level.max(), drop=True)
    return np.hypot(float(place.x[0]) * 1e3 - target.x_mm, float(place.y[0]) * 1e3 - target.y_mm)


@pytest.mark.parametrize(("seed", "method"), list(enumerate(EXACT)))
def test_a_finer_image_has_the_same_values_and_shows_a_target_nearer_to_its_place(method, seed):
    random = np.random.default_rng(seed)
    columns = random.integers(6, 14, 2)
    # In the middle between positions of the survey.
    target = point(X_MM[columns[0]] + 7.5, Y_MM[columns[1]] + 7.5, random.uniform(0.06, 0.13))
    survey = survey_with(target)
    plain, fine = imaged(survey, method, None), imaged(survey, method, 0.003)
    assert fine.image.shape == (1, len(DEPTH_M), 81, 101)
    np.testing.assert_allclose(fine.x[::5], plain.x, atol=1e-12)
    largest = float(abs(plain.image).max())
    np.testing.assert_allclose(
        fine.image[..., ::5, ::5].values, plain.image.values, rtol=0.0, atol=2e-6 * largest
    )
    assert brightest_voxel_error_mm(plain, target) > 10.0
    assert brightest_voxel_error_mm(fine, target) < 3.5
    assert fine.x.attrs == plain.x.attrs


def test_an_image_that_does_not_fit_into_the_memory_is_refused(monkeypatch):
    survey = survey_with(point(200, 200, 0.1))
    monkeypatch.setattr(lazy, "available_bytes", lambda: 20_000_000)
    for step_m in (0.0009, 0.0, 1.1, float("nan")):
        with raises_fault(faults.OPTION):
            ImageOptions(Method.PHASE_SHIFT, 4.0, grid_step_m=step_m)
    with raises_fault(faults.TOO_LARGE, "1 x 30 x 241 x 301 voxels needs"):
        imaged(survey, Method.PHASE_SHIFT, 0.001)
    assert imaged(survey, Method.PHASE_SHIFT, 0.01).image.any()


HEIGHTS_M = st.floats(0.02, 0.6)
DEPTHS_M = st.floats(0.005, 1.0)
PERMITTIVITIES = st.floats(1.0, 81.0)


@given(HEIGHTS_M, DEPTHS_M, st.lists(st.floats(0.0, 2.0), min_size=1, max_size=20), PERMITTIVITIES)
def test_both_find_the_same_way_through_the_surface(height_m, depth_m, distances_m, permittivity):
    distance_m = np.array(distances_m)
    path = refracted_path(height_m, np.full_like(distance_m, depth_m), distance_m, permittivity)
    simulated_s = (path.air_m + math.sqrt(permittivity) * path.soil_m) / speed_of_light
    analysed_s = one_way_delay_s(height_m, depth_m, distance_m, permittivity)
    # 1e-9 of 2 m in soil of permittivity 81 is 2 mrad at 6 GHz.
    np.testing.assert_allclose(analysed_s, simulated_s, rtol=1e-9)
