"""Heights of the antennas that differ: the background at the surface, the image, the refusal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import faults
from gpr20_analysis.dataset import HEIGHT, S21, Quality
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.one_height import TOLERANCE, points_needed, transform_at_one_height
from gpr20_analysis.imaging.records import Focus, Ground
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_analysis.processing.delay import set_time_zero
from gpr20_simulator.mid.world.scene import Surface

# Echoes 14 dB weaker than those of the other imaging tests, 25 dB below that of the surface.
TARGETS = (point(173.3, 181.7, 0.1134, 0.01), point(318.9, 307.4, 0.0711, 0.01))
SHALLOW_M = 0.03
SENSOR_NOISE_M = 0.001
SEEDS = range(3)
FEW_MM = np.linspace(60.0, 420.0, 9)


def lifted(seed, most_m, noise_m=SENSOR_NOISE_M):
    """Return a survey with antennas at random heights, recorded with noise."""
    random = np.random.default_rng(seed)
    survey = survey_of(
        scene(TARGETS, noise_db=-90.0),
        rotations_deg=(0.0,),
        height_m=lambda x_mm, y_mm: 0.2 + random.uniform(-most_m, most_m),
    )
    return survey.assign(height=survey.height + random.normal(0.0, noise_m, survey.height.shape))


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


@pytest.mark.parametrize(
    ("method", "seed"),
    [(Method.PHASE_SHIFT, 0), (Method.PHASE_SHIFT, 1), (Method.BACK_PROJECTION, 0)],
)
def test_heights_that_vary_by_40_mm_give_no_false_echoes(method, seed):
    options = ImageOptions(method, 4.0, ground=Ground.LEVEL)
    level = peaks_and_clutter_db(image_survey(remove_background(lifted(seed, 0.0)), options))
    survey = lifted(seed, 0.02)
    varied = peaks_and_clutter_db(image_survey(remove_background(survey), options))
    assert varied[0] > level[0] - 2.0
    assert varied[2] < level[2] + 3.0
    # The rest is the noise of the height sensor.
    assert varied[1] < varied[0] - 6.0
    by_mean = image_survey(remove_background(survey, Background.MEAN), options)
    assert peaks_and_clutter_db(by_mean)[1] > varied[0]


def test_noise_of_the_height_sensor_changes_little():
    options = ImageOptions(Method.PHASE_SHIFT, 4.0)
    survey = lifted(0, 0.0, noise_m=0.002)
    cleaned = remove_background(survey)
    np.testing.assert_array_equal(cleaned.s21, remove_background(survey, Background.MEAN).s21)
    peak, shallow, deep = peaks_and_clutter_db(image_survey(cleaned, options))
    without = image_survey(remove_background(lifted(0, 0.0, noise_m=0.0)), options)
    assert peak > peaks_and_clutter_db(without)[0] - 1.0
    assert max(shallow, deep) < peak - 15.0


def test_uneven_ground_is_refused_in_favour_of_back_projection():
    surface = Surface(wave_amplitude_m=0.012, wave_length_m=0.4)
    uneven = replace(scene(TARGETS, noise_db=-90.0), surface=surface)
    survey = remove_background(survey_of(uneven, FEW_MM, FEW_MM, rotations_deg=(0.0,)))
    with raises_fault(faults.METHOD):
        image_survey(survey, ImageOptions(Method.PHASE_SHIFT, 4.0))
    stated = image_survey(survey, ImageOptions(Method.PHASE_SHIFT, 4.0, ground=Ground.LEVEL))
    assert stated.attrs["notes"] == []


def test_one_height_for_all_is_never_refused():
    survey = remove_background(lifted(1, 0.02))
    assert image_survey(survey, ImageOptions(Method.PHASE_SHIFT, 4.0, height_m=0.2)).image.any()


def empty_ground(seed, most_m=0.02, **antennas):
    random = np.random.default_rng(seed)
    return survey_of(
        scene([], noise_db=-300.0, **antennas),
        *(FEW_MM, FEW_MM),
        height_m=lambda x_mm, y_mm: 0.2 + random.uniform(-most_m, most_m),
    )


def left_db(survey, method=Background.SURFACE):
    left = np.nansum(np.abs(remove_background(survey, method).s21) ** 2)
    return float(10.0 * np.log10(left / np.nansum(np.abs(survey.s21) ** 2)))


@pytest.mark.parametrize("seed", SEEDS)
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


def test_missing_samples_stay_missing_and_are_ignored():
    survey = empty_ground(4)
    whole = remove_background(survey)
    for hole in ((0, 3, 2), (1, 0, 0)):
        survey.s21.values[hole] = np.nan
        survey.quality.values[hole] = int(Quality.MISSING)
        survey.height.values[hole] = np.nan
    cleaned = remove_background(survey)
    assert left_db(survey) < -150.0
    np.testing.assert_array_equal(np.isnan(cleaned.s21), np.isnan(survey.s21))
    assert cleaned.s21.dims == whole.s21.dims


def test_the_surface_is_the_mean_where_heights_say_nothing():
    survey = lifted(1, 0.02)
    few = survey.isel(x=slice(4), y=slice(4))
    without_height = survey.drop_vars(HEIGHT)
    partly = survey.copy(deep=True)
    partly.height.values[0, 2, 3] = np.nan
    equal = survey.assign(height=survey.height * 0.0 + 0.2)
    for one in (few, without_height, partly, equal):
        by_mean = remove_background(one, Background.MEAN)
        np.testing.assert_array_equal(remove_background(one)[S21], by_mean[S21])


def test_a_polarization_whose_surface_does_not_follow_the_heights_loses_the_mean():
    survey = empty_ground(6, most_m=0.0)
    moved = empty_ground(6)
    survey.s21.values[1], survey.height.values[:] = moved.s21.values[1], moved.height.values[1]
    cleaned = remove_background(survey)
    by_mean = remove_background(survey, Background.MEAN)
    np.testing.assert_allclose(cleaned.s21[0], by_mean.s21[0], atol=1e-15)
    assert float(abs(cleaned.s21[1]).max()) < 1e-9 < float(abs(by_mean.s21[1]).max())


def test_a_lazy_survey_loses_the_same_background():
    survey = empty_ground(2)
    survey.s21.values[0, 3, 2] = np.nan
    expected = remove_background(survey)
    for rows in (1, 4):
        chunked = survey.assign(s21=survey.s21.chunk({"polarization": 1, "y": rows}))
        cleaned = remove_background(chunked)
        assert cleaned.s21.chunks is not None
        np.testing.assert_allclose(cleaned.s21, expected.s21, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_transform_at_one_height_is_the_sum_over_plane_waves(seed):
    random = np.random.default_rng(seed)
    shape, padded, step_m = (6, 5), (9, 8), 0.03
    focus = Focus(4.0, np.array([0.0, 0.1]))
    air_rad_m = np.linspace(30.0, 250.0, 7)
    across = [2.0 * np.pi * np.fft.fftfreq(count, step_m) for count in padded]
    across_rad_m = np.hypot(across[0][:, None], across[1][None, :]).ravel()
    most_m = 10.0 ** random.uniform(-4.0, -1.0)
    higher_m = random.uniform(-most_m, most_m, shape)
    spectra = random.normal(size=(7, *shape)) + 1j * random.normal(size=(7, *shape))
    found = transform_at_one_height(
        spectra.astype(np.complex64), higher_m, padded, air_rad_m, across_rad_m, focus
    )
    down = np.sqrt(np.maximum(air_rad_m[:, None] ** 2 - across_rad_m**2, 0.0))
    expected = np.zeros_like(found, dtype=np.complex128)
    for row, column in np.ndindex(*shape):
        away = np.add.outer(row * step_m * across[0], column * step_m * across[1]).ravel()
        expected += spectra[:, row, column, None] * np.exp(
            1j * (down * higher_m[row, column] - away)
        )
    taken = across_rad_m < air_rad_m[:, None] * np.sin(np.radians(focus.widest_angle_deg))
    error = np.abs(found - expected)[taken]
    assert np.sqrt(np.mean(error**2)) < TOLERANCE * np.sqrt(np.mean(np.abs(expected[taken]) ** 2))


def test_more_points_are_used_for_larger_phases():
    counts = [points_needed(phase) for phase in (0.0, 0.02, 0.3, 1.0, 3.0, 10.0)]
    assert counts[:2] == [1, 1]
    assert counts == sorted(counts)
    assert counts[-1] < 25
