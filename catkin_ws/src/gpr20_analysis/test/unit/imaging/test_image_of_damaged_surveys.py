"""What is missing or damaged never gives a wrong picture silently."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import faults
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.display import apply_gain
from gpr20_analysis.processing.samples import fill_missing

PLACES_MM = np.linspace(120.0, 360.0, 21)
TARGET = point(243.7, 236.2, 0.083)


def survey(*missing):
    """Return a survey in which some samples (polarization, y, x) are missing."""
    whole = survey_of(scene([TARGET]), PLACES_MM, PLACES_MM, rotations_deg=(0.0,))
    for place in missing:
        whole.s21.values[place] = np.nan
        whole.height.values[place] = np.nan
        whole.quality.values[place] = int(Quality.MISSING)
    return whole


HOLES = [(0, 3, 4), (0, 10, 10), (0, 20, 0)]
METHODS = [Method.PHASE_SHIFT, Method.BACK_PROJECTION]


def test_missing_samples_are_refused_and_counted():
    holed = survey(*HOLES)
    for method in METHODS:
        with raises_fault(faults.SAMPLES_MISSING, "3 samples have no data"):
            image_survey(holed, ImageOptions(method, 4.0))


@pytest.mark.parametrize("method", METHODS)
def test_left_out_samples_are_said_and_move_nothing(method):
    options = ImageOptions(method, 4.0, leave_out_missing=True)
    image = image_survey(remove_background(survey(*HOLES)), options)
    assert any("3 of 441 samples were left out" in note for note in image.attrs["notes"])
    echo = find_candidates(image).candidates[0]
    assert abs(echo.x_m - TARGET.x_mm / 1e3) < 2e-3
    assert abs(echo.depth_m - TARGET.depth_m) < 2e-3
    assert np.all(np.isfinite(image.image.values))


def test_filled_samples_are_said_and_near_the_measured():
    whole = survey()
    filled = fill_missing(survey(*HOLES))
    assert int(filled.filled.sum()) == 3
    assert any("3 samples" in note for note in filled.attrs["notes"])
    place = HOLES[1]
    error = np.abs(filled.s21.values[place] - whole.s21.values[place]).max()
    assert error < 0.3 * np.abs(whole.s21.values[place]).max()
    image = image_survey(remove_background(filled), ImageOptions(permittivity=4.0))
    assert any("not measured" in note for note in image.attrs["notes"])


def test_too_many_holes_are_not_filled():
    with raises_fault(faults.SAMPLES_MISSING):
        fill_missing(survey(*[(0, row, 5) for row in range(21)], *[(0, 2, c) for c in range(21)]))


def test_a_hole_without_neighbours_is_not_filled():
    block = [(0, row, column) for row in range(4, 7) for column in range(4, 7)]
    with raises_fault(faults.SAMPLES_MISSING):
        fill_missing(survey(*block))


def test_a_missing_sample_does_not_spread_through_the_background():
    holed = survey(*HOLES)
    for method in (Background.MEAN, Background.MEDIAN, Background.MOVING):
        cleaned = remove_background(holed, method)
        absent = np.isnan(cleaned.s21.values).all(axis=-1)
        assert sorted(map(tuple, np.argwhere(absent))) == HOLES, method
        assert not np.isnan(cleaned.s21.values[~absent]).any(), method
    with raises_fault(faults.SAMPLES_MISSING):
        remove_background(holed, Background.SVD)


def test_nan_in_a_sample_that_is_called_good_is_refused():
    broken = survey()
    broken.s21.values[0, 3, 3, 7] = np.nan
    with raises_fault(faults.STEPS):
        image_survey(broken, ImageOptions(permittivity=4.0))


def test_missing_heights_are_refused_and_one_height_can_be_given():
    unknown = survey()
    unknown.height.values[0, 5, 6] = np.nan
    with raises_fault(faults.NO_HEIGHT, "1 usable samples have no height"):
        image_survey(unknown, ImageOptions(permittivity=4.0))
    with raises_fault(faults.NO_HEIGHT):
        set_time_zero(unknown)
    image_survey(unknown, ImageOptions(permittivity=4.0, height_m=0.2))


def test_mixed_frequencies_are_refused():
    uneven = survey()
    frequency_hz = uneven.frequency.values.copy()
    frequency_hz[50:] += 20e6
    with raises_fault(faults.SWEEP):
        image_survey(uneven.assign_coords(frequency=frequency_hz), ImageOptions(permittivity=4.0))


def test_data_with_gain_are_not_imaged():
    with raises_fault(faults.STEPS):
        image_survey(apply_gain(to_time(survey())), ImageOptions(permittivity=4.0))


def test_options_that_make_no_image_are_refused():
    for wrong in (
        {"permittivity": 0.5},
        {"permittivity": float("nan")},
        {"height_m": 0.0},
        {"depth_m": (0.1,)},
        {"depth_m": (0.2, 0.1)},
        {"depth_m": (-0.1, 0.1)},
        {"widest_angle_deg": 90.0},
        {"separation_m": -1.0},
    ):
        with pytest.raises(WrongDatasetError):
            ImageOptions(**wrong)
