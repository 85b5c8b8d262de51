"""The grid of an image that is not that of the survey."""

from __future__ import annotations

import argparse

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import faults, lazy
from gpr20_analysis.commands import image_command
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method

EXACT = (Method.PHASE_SHIFT, Method.BACK_PROJECTION)
QUIET = {"coupling_level_db": -200.0, "surface_gain_db": -200.0}
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


@pytest.mark.parametrize(("seed", "method"), enumerate(EXACT))
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


@pytest.mark.parametrize("method", EXACT)
def test_the_extent_is_that_of_the_survey_for_any_step(method):
    image = imaged(survey_with(point(200, 200, 0.1)), method, 0.007)
    for axis, place_mm in ((image.x, X_MM), (image.y, Y_MM)):
        assert (float(axis[0]), float(axis[-1])) == (place_mm[0] / 1e3, place_mm[-1] / 1e3)
        assert 0.006 < np.diff(axis).min() <= np.diff(axis).max() <= 0.007
    assert '"grid_step_m": 0.007' in image.attrs["imaging"]


def test_positions_that_are_not_regular_are_imaged_on_a_regular_grid_by_back_projection():
    target = point(203.0, 211.0, 0.1)
    x_mm = X_MM + np.random.default_rng(3).uniform(-4.0, 4.0, X_MM.size)
    survey = survey_with(target, x_mm=x_mm)
    image = imaged(survey, Method.BACK_PROJECTION, 0.004)
    assert np.ptp(np.diff(image.x)) < 1e-9
    assert brightest_voxel_error_mm(image, target) < 4.0
    with raises_fault(faults.METHOD):
        imaged(survey, Method.PHASE_SHIFT, 0.004)


def test_steps_out_of_range_are_refused():
    for step_m in (0.0009, 0.0, -0.01, 1.1, float("nan")):
        with raises_fault(faults.OPTION):
            ImageOptions(Method.PHASE_SHIFT, 4.0, grid_step_m=step_m)


def test_an_image_that_does_not_fit_into_the_memory_is_refused(monkeypatch):
    survey = survey_with(point(200, 200, 0.1))
    monkeypatch.setattr(lazy, "available_bytes", lambda: 20_000_000)
    with raises_fault(faults.TOO_LARGE, "1 x 30 x 241 x 301 voxels needs"):
        imaged(survey, Method.PHASE_SHIFT, 0.001)
    assert imaged(survey, Method.PHASE_SHIFT, 0.01).image.any()


def test_the_command_takes_the_step_in_mm():
    parser = argparse.ArgumentParser()
    image_command.add_image_options(parser)
    assert image_command.options_of(parser.parse_args(["--grid-step", "5"])).grid_step_m == 0.005
    assert image_command.options_of(parser.parse_args([])).grid_step_m is None
