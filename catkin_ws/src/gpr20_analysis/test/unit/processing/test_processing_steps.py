"""Each step on the Dataset of a survey against what it must do to known echoes."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.constants import speed_of_light

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.background import Background, remove_background, subtract_coupling
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.display import Gain, apply_gain
from gpr20_analysis.processing.polarization import (
    Combination,
    combine_polarizations,
    select_polarization,
)
from gpr20_analysis.processing.sweep import FrequencyGrid, apply_window, select_band
from gpr20_survey.radar.frequency_to_delay import Window

PLACES_MM = np.linspace(120.0, 360.0, 13)
NONE_DB = {"coupling_level_db": -200.0, "surface_gain_db": -200.0}
TARGET = point(243.7, 236.2, 0.083)


def survey(*targets, rotations_deg=(0.0, 90.0), noise_db=-140.0, **antennas):
    ground = scene(targets, noise_db=noise_db, **antennas)
    return survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=rotations_deg)


@pytest.fixture(scope="module")
def single_trace():
    return survey(TARGET).isel(polarization=[0], x=[0], y=[0])


def power(data):
    return float(np.mean(np.abs(data.s21.values) ** 2))


def test_background_removal_takes_coupling_and_surface_and_keeps_the_target():
    with_all, alone = survey(TARGET), survey(TARGET, **NONE_DB)
    assert power(with_all) > 20.0 * power(alone)
    for method in Background:
        cleaned = remove_background(with_all, method, width=13)
        # What is left is the target, less what of it is the same everywhere.
        assert 0.2 * power(alone) < power(cleaned) < 1.2 * power(alone), method


def test_svd_of_higher_rank_takes_more():
    left = [power(remove_background(survey(TARGET), Background.SVD, rank=n)) for n in (1, 2, 3)]
    assert left[0] > left[1] > left[2]


def test_background_parameters_that_do_not_suit_are_refused():
    measured = survey(TARGET)
    for wrong in (
        {"method": Background.SVD, "rank": 0},
        {"method": Background.SVD, "rank": 101},
        {"method": Background.MOVING, "width": 4},
        {"method": Background.MOVING, "width": 1},
    ):
        with pytest.raises(WrongDatasetError):
            remove_background(measured, **wrong)


def test_coupling_subtraction_leaves_surface_and_target():
    reference = survey(surface_gain_db=-200.0)
    cleaned = subtract_coupling(survey(TARGET), reference)
    wanted = survey(TARGET, coupling_level_db=-200.0)
    np.testing.assert_allclose(cleaned.s21.values, wanted.s21.values, atol=2e-6)


def test_reference_of_another_sweep_or_rotation_is_refused():
    reference = survey()
    with raises_fault(faults.REFERENCE):
        subtract_coupling(survey(TARGET), reference.isel(frequency=slice(0, 50)))
    with raises_fault(faults.REFERENCE, "no rotation 90"):
        subtract_coupling(survey(TARGET), reference.isel(polarization=[0]))


def test_the_survey_itself_is_no_reference():
    named = survey(TARGET).assign_attrs(survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7")
    with raises_fault(faults.REFERENCE):
        subtract_coupling(named, named)


@settings(max_examples=25)
@given(
    delay_s=st.floats(0.5e-9, 17e-9),
    start_hz=st.floats(1e8, 2e9),
    padding=st.floats(1.0, 12.0),
    window=st.sampled_from(list(Window)),
)
def test_an_echo_stands_at_its_delay_with_its_phase(
    single_trace, delay_s, start_hz, padding, window
):
    sweep = FrequencyGrid(start_hz, 54e6, 101)
    echo = np.exp(-2j * np.pi * sweep.frequency_hz * delay_s).reshape(1, 1, 1, -1)
    one = single_trace.assign_coords(frequency=sweep.frequency_hz)
    one = one.assign(s21=(one.s21.dims, echo))
    in_time = to_time(one, window, padding)
    trace = in_time.a_scan.values[0, 0, 0]
    delays_s = in_time.delay.values
    at = int(np.argmax(np.abs(trace)))
    # The last bin neighbours the first: time repeats after 1 / step.
    off_s = (delays_s[at] - delay_s + 0.5 / 54e6) % (1.0 / 54e6) - 0.5 / 54e6
    assert abs(off_s) <= 0.51 * delays_s[1]
    centre_hz = start_hz + 27e8
    assert abs(np.angle(trace[at] * np.exp(-2j * np.pi * centre_hz * off_s))) < 1e-6
    assert np.abs(trace[at]) <= 1.0 + 1e-9


def test_an_echo_of_one_has_magnitude_one():
    one = survey(TARGET).isel(polarization=[0], x=[0], y=[0])
    in_time = to_time(one.assign(s21=one.s21 * 0.0 + 1.0))
    assert np.abs(in_time.a_scan.values[0, 0, 0, 0]) == pytest.approx(1.0)


def test_padding_below_one_is_refused():
    with raises_fault(faults.OPTION):
        to_time(survey(TARGET), padding=0.5)


def test_time_zero_puts_the_surface_at_delay_zero():
    one = survey(height_m=0.173, coupling_level_db=-200.0).isel(polarization=[0])
    trace = to_time(set_time_zero(one)).a_scan.values[0, 0, 0]
    assert int(np.argmax(np.abs(trace))) == 0
    assert float(set_time_zero(one).advance[0, 0, 0]) == pytest.approx(2.0 * 0.173 / speed_of_light)


def test_band_selection_keeps_both_ends_and_refuses_an_empty_band():
    band = select_band(survey(TARGET), 1.14e9, 1.248e9)
    np.testing.assert_allclose(band.frequency.values, [1.14e9, 1.194e9, 1.248e9])
    with raises_fault(faults.OPTION, "contains 0 frequencies"):
        select_band(survey(TARGET), 7e9, 8e9)


def test_windows_are_symmetric_positive_and_nowhere_zero():
    measured = survey(TARGET)
    for window in Window:
        weights = window.weights(101)
        assert np.all(weights > 0.0) and weights.max() == pytest.approx(1.0, abs=0.01)
        np.testing.assert_allclose(weights, weights[::-1])
        assert power(apply_window(measured, window)) <= power(measured) * 1.0001


def test_difference_shows_what_one_polarization_sees_alone():
    both, wire = survey(TARGET), survey(TARGET)
    wire.s21[1] += 1e-3
    assert power(combine_polarizations(both, Combination.DIFFERENCE)) < 1e-6 * power(both)
    difference = combine_polarizations(wire, Combination.DIFFERENCE)
    np.testing.assert_allclose(difference.s21.values, -0.5e-3, atol=1e-5)
    assert np.isnan(difference.polarization.values[0])
    assert "difference" in difference.attrs["polarizations"]


def test_a_combination_can_be_imaged_and_needs_two():
    combined = combine_polarizations(remove_background(survey(TARGET)))
    assert image_survey(combined, ImageOptions(permittivity=4.0)).sizes["polarization"] == 1
    with raises_fault(faults.STEPS):
        combine_polarizations(combined)


def test_a_rotation_that_was_not_measured_is_refused():
    assert select_polarization(survey(TARGET), 90.0).polarization.values == [90.0]
    with raises_fault(faults.OPTION):
        select_polarization(survey(TARGET), 45.0)


def test_gain_raises_late_samples_and_says_so():
    measured = survey(TARGET)
    in_time = to_time(measured)
    late = {"delay": slice(10e-9, 15e-9)}
    early = {"delay": slice(0.5e-9, 3e-9)}

    def ratio(data):
        return float(abs(data.a_scan.sel(late)).mean() / abs(data.a_scan.sel(early)).mean())

    for method in Gain:
        raised = apply_gain(in_time, method, db_per_ns=2.0)
        assert ratio(raised) > ratio(in_time), method
        assert method.value in raised.attrs["display_only"]
    with raises_fault(faults.STEPS):
        apply_gain(measured)
