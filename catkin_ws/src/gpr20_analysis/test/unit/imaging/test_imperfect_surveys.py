"""Heights that differ, and what is missing or damaged, give no wrong picture silently."""

from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from run_seed import draws

from gpr20_analysis import errors
from gpr20_analysis.candidates.answer import answer
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import DISPLAY_ONLY, HEIGHT, S21, Quality
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_common.faults import NOT_ALLOWED
from gpr20_simulator.mid.world.scene import Surface

# Echoes 14 dB weaker than those of the other tests, 25 dB below that of the surface.
TARGETS = (point(173.3, 181.7, 0.1134, 0.01), point(318.9, 307.4, 0.0711, 0.01))
SHALLOW_M = 0.03
FEW_MM = np.linspace(60.0, 420.0, 9)
METHODS = [Method.PHASE_SHIFT, Method.BACK_PROJECTION]


def lifted(seed, most_m):
    """Return a survey with antennas at random heights, recorded with noise."""
    random = np.random.default_rng(seed)
    survey = survey_of(
        scene(TARGETS, noise_db=-90.0),
        *(np.linspace(115.0, 370.0, 18),) * 2,
        rotations_deg=(0.0,),
        height_m=lambda x_mm, y_mm: 0.2 + random.uniform(-most_m, most_m),
    )
    return survey.assign(height=survey.height + random.normal(0.0, 0.001, survey.height.shape))


def peaks_and_clutter_db(image):
    """Return the levels of the targets, and the highest shallow and deep level elsewhere [dB]."""
    level = 20.0 * np.log10(abs(image.image[0]))
    elsewhere, peaks = level, []
    for target in TARGETS:
        across_m = np.hypot(image.x - target.x_mm / 1e3, image.y - target.y_mm / 1e3)
        down_m = abs(image.depth - target.depth_m)
        peaks.append(float(level.where((across_m < 0.02) & (down_m < 0.008)).max()))
        elsewhere = elsewhere.where((across_m > 0.08) | (down_m > 0.06))
    shallow = elsewhere.where(image.depth < SHALLOW_M).max()
    return min(peaks), float(shallow), float(elsewhere.where(image.depth >= SHALLOW_M).max())


@pytest.mark.parametrize("method", METHODS)
def test_heights_that_vary_by_40_mm_give_no_false_echoes(method):
    options = ImageOptions(method, 4.0, ground=Ground.LEVEL)
    level = peaks_and_clutter_db(image_survey(remove_background(lifted(0, 0.0)), options))
    survey = lifted(0, 0.02)
    varied = peaks_and_clutter_db(image_survey(remove_background(survey), options))
    assert varied[0] > level[0] - 2.0
    assert varied[2] < level[2] + 3.0
    # The rest is the noise of the height sensor.
    assert varied[1] < varied[0] - 6.0
    by_mean = image_survey(remove_background(survey, Background.MEAN), options)
    assert peaks_and_clutter_db(by_mean)[1] > varied[0]


def test_uneven_ground_is_refused_in_favour_of_back_projection():
    surface = Surface(wave_amplitude_m=0.012, wave_length_m=0.4)
    uneven = replace(scene(TARGETS, noise_db=-90.0), surface=surface)
    survey = remove_background(survey_of(uneven, FEW_MM, FEW_MM, rotations_deg=(0.0,)))
    with raises_fault(NOT_ALLOWED):
        image_survey(survey, ImageOptions(Method.PHASE_SHIFT, 4.0))
    stated = image_survey(survey, ImageOptions(Method.PHASE_SHIFT, 4.0, ground=Ground.LEVEL))
    assert stated.attrs["notes"] == []


def empty_ground(seed, most_m=0.02, **antennas):
    random = np.random.default_rng(seed)
    ground = scene([], noise_db=-300.0, **antennas)
    return survey_of(
        ground, FEW_MM, FEW_MM, height_m=lambda x_mm, y_mm: 0.2 + random.uniform(-most_m, most_m)
    )


def left_db(survey, method=Background.SURFACE):
    left = np.nansum(np.abs(remove_background(survey, method).s21) ** 2)
    return float(10.0 * np.log10(left / np.nansum(np.abs(survey.s21) ** 2)))


@pytest.mark.parametrize("seed", range(draws(1)))
def test_coupling_and_surface_echo_are_removed_at_any_height(seed):
    survey = empty_ground(seed)
    assert left_db(survey) < -150.0
    assert left_db(survey, Background.MEAN) > -20.0
    # The path between antennas that are apart, and a delay of cables, are taken up to first order.
    assert left_db(empty_ground(seed, separation_m=0.06)) < -60.0
    delayed = np.exp(-2j * np.pi * survey.frequency * 0.3e-9)
    assert left_db(survey.assign(s21=survey.s21 * delayed)) < -150.0
    assert left_db(survey.assign(height=survey.height * 1.02)) < -40.0
    assert left_db(set_time_zero(survey)) < -150.0
    for hole in ((0, 3, 2), (1, 0, 0)):
        survey.s21.values[hole] = survey.height.values[hole] = np.nan
        survey.quality.values[hole] = int(Quality.MISSING)
    cleaned = remove_background(survey)
    assert left_db(survey) < -150.0
    np.testing.assert_array_equal(np.isnan(cleaned.s21), np.isnan(survey.s21))


def test_the_surface_is_the_mean_where_heights_say_nothing():
    survey, moved = empty_ground(6, most_m=0.0), empty_ground(6)
    partly = moved.copy(deep=True)
    partly.height.values[0, 2, 3] = np.nan
    few, without_height = moved.isel(x=slice(4), y=slice(4)), moved.drop_vars(HEIGHT)
    equal = moved.assign(height=moved.height * 0.0 + 0.2)
    for one in (few, without_height, partly.isel(polarization=[0]), equal):
        by_mean = remove_background(one, Background.MEAN)
        np.testing.assert_array_equal(remove_background(one)[S21], by_mean[S21])
    # Of two polarizations only the one whose surface does not follow the heights.
    survey.s21.values[1], survey.height.values[:] = moved.s21.values[1], moved.height.values[1]
    cleaned, by_mean = remove_background(survey), remove_background(survey, Background.MEAN)
    np.testing.assert_allclose(cleaned.s21[0], by_mean.s21[0], atol=1e-13)
    assert float(abs(cleaned.s21[1]).max()) < 1e-9 < float(abs(by_mean.s21[1]).max())


PLACES_MM = np.linspace(120.0, 360.0, 21)
AREA_M2 = 0.24**2
TARGET = point(243.7, 236.2, 0.083)
HOLES = [(0, 3, 4), (0, 10, 10), (0, 20, 0)]


def holed(*missing):
    """Return a survey in which some samples (polarization, y, x) are missing."""
    whole = survey_of(scene([TARGET]), PLACES_MM, PLACES_MM, rotations_deg=(0.0,))
    for place in missing:
        whole.s21.values[place] = whole.height.values[place] = np.nan
        whole.quality.values[place] = int(Quality.MISSING)
    return whole


@pytest.mark.parametrize("method", METHODS)
def test_missing_samples_are_refused_or_left_out_said_and_move_nothing(method):
    with raises_fault(errors.INPUT, "samples without data: 3"):
        image_survey(holed(*HOLES), ImageOptions(method, 4.0))
    options = ImageOptions(method, 4.0, leave_out_missing=True)
    image = image_survey(remove_background(holed(*HOLES)), options)
    assert any("3 of 441 samples were left out" in note for note in image.attrs["notes"])
    echo = find_candidates(image).candidates[0]
    assert abs(echo.x_m - TARGET.x_mm / 1e3) < 2e-3
    assert abs(echo.depth_m - TARGET.depth_m) < 2e-3
    assert np.all(np.isfinite(image.image.values))


@pytest.mark.parametrize("rows, columns", [(14, 21), (21, 9), (12, 10)])
def test_ground_around_a_survey_that_was_cut_off_counts_as_not_searched(rows, columns):
    places = [(0, y, x) for y in range(21) for x in range(21) if y >= rows or x >= columns]
    options = ImageOptions(Method.PHASE_SHIFT, 4.0, leave_out_missing=True)
    found = answer(holed(*places), options).found
    around = f"{len(places)} planned samples around the image were not measured"
    assert any(around in str(note) for note in found.notes)
    assert found.area_m2 == pytest.approx((rows - 1) * (columns - 1) / 400 * AREA_M2)


def test_a_missing_sample_does_not_spread_through_the_background():
    survey = holed(*HOLES)
    for method in (Background.MEAN, Background.MOVING):
        cleaned = remove_background(survey, method)
        absent = np.isnan(cleaned.s21.values).all(axis=-1)
        assert sorted(map(tuple, np.argwhere(absent))) == HOLES, method
        assert not np.isnan(cleaned.s21.values[~absent]).any(), method


def test_what_cannot_be_imaged_is_refused():
    broken, whole, unknown = holed(), holed(), holed()
    broken.s21.values[0, 3, 3, 7] = unknown.height.values[0, 5, 6] = np.nan
    frequency_hz = whole.frequency.values.copy()
    frequency_hz[50:] += 20e6
    for fault, data in (
        (errors.STEPS, broken),
        (errors.STEPS, whole.assign_attrs({DISPLAY_ONLY: "gain"})),
        (errors.STEPS, to_time(whole)),
        (errors.INPUT, whole.assign_coords(frequency=frequency_hz)),
        (NOT_ALLOWED, unknown),
        (NOT_ALLOWED, whole.assign_coords(x=whole.x.values**2)),
        (NOT_ALLOWED, whole.isel(x=[4], y=[4])),
        # A step of 540 MHz repeats after 1.9 ns, and a band of 108 MHz resolves 9 ns.
        (NOT_ALLOWED, whole.isel(frequency=slice(None, None, 10))),
        (NOT_ALLOWED, whole.isel(frequency=slice(2))),
    ):
        with raises_fault(fault):
            image_survey(data, ImageOptions(permittivity=4.0))
    with raises_fault(NOT_ALLOWED):
        set_time_zero(unknown)
    image_survey(unknown, ImageOptions(permittivity=4.0, height_m=0.2))
    for wrong in (
        *({"permittivity": 0.5}, {"permittivity": float("nan")}, {"height_m": 0.0}),
        *({"depth_m": (0.1,)}, {"depth_m": (0.2, 0.1)}),
        {"separation_m": -1.0},
    ):
        with raises_fault(NOT_ALLOWED):
            ImageOptions(**wrong)
