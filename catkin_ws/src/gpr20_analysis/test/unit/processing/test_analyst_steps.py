"""Dewow, f-k filter, robust PCA, time zero, topography, gain and envelope against references."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from scipy.constants import speed_of_light

from gpr20_analysis import faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.common import Imported, as_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.display import Gain, apply_gain, envelope
from gpr20_analysis.processing.filters import Along, dewow, filter_dips
from gpr20_analysis.processing.robust_pca import principal_component_pursuit, remove_low_rank
from gpr20_analysis.processing.time_zero import Arrival, correct_topography, pick_time_zero
from gpr20_survey.radar.frequency_to_delay import Window

PLACES_MM = np.linspace(120.0, 360.0, 13)
TARGET = point(243.7, 236.2, 0.083)


def survey(*targets, height_m=None, noise_db=-140.0, **antennas):
    ground = scene(targets, noise_db=noise_db, **antennas)
    return survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=(0.0,), height_m=height_m)


def wavy_m(x_mm, y_mm):
    return 0.2 + 0.012 * np.sin(x_mm / 60.0) + 0.008 * np.cos(y_mm / 50.0)


def holed(made):
    made.s21[0, 4, 4] = np.nan
    made.quality[0, 4, 4] = int(Quality.MISSING)
    return made


# Dewow


@pytest.mark.parametrize("window_s", [1e-9, 2e-9])
def test_dewow_of_spectra_is_the_trace_less_its_running_mean(window_s):
    made = survey(TARGET)
    in_time = to_time(made, Window.NONE, padding=64.0)
    trace, step_s = in_time.a_scan.values[0, 6, 6], float(in_time.delay[1])
    width = 2 * round(window_s / step_s / 2.0) + 1
    mean = np.convolve(trace, np.ones(width) / width, "same")
    found = to_time(dewow(made, window_s), Window.NONE, padding=64.0).a_scan.values[0, 6, 6]
    inner = slice(width, -width)
    expected = (trace - mean)[inner]
    np.testing.assert_allclose(found[inner], expected, atol=0.02 * abs(expected).max())


def test_dewow_of_a_scans_removes_offset_and_drift_and_keeps_the_pulse():
    in_time = to_time(survey(TARGET))
    drift = 1.0 + in_time.delay / in_time.delay[-1]
    found = dewow(in_time.assign(a_scan=in_time.a_scan + drift), 2e-9)
    expected = dewow(in_time, 2e-9)
    inner = {"delay": slice(2e-9, 15e-9)}
    np.testing.assert_allclose(found.a_scan.sel(inner), expected.a_scan.sel(inner), atol=1e-9)
    kernel = np.ones(2 * int(1e-9 / float(in_time.delay[1])) + 1)
    trace = in_time.a_scan.values[0, 3, 3]
    mean = np.convolve(trace, kernel, "same") / np.convolve(np.ones(len(trace)), kernel, "same")
    np.testing.assert_allclose(expected.a_scan.values[0, 3, 3], trace - mean, atol=1e-12)


def test_dewow_needs_a_window_and_three_samples_in_it():
    empty = survey()
    for window_s in (0.0, -1e-9, float("nan")):
        with raises_fault(faults.OPTION):
            dewow(empty, window_s)
    with raises_fault(faults.OPTION):
        dewow(to_time(empty), 1e-13)


# The f-k filter


def plane_wave(dip_deg, along):
    frequency_hz = np.linspace(600e6, 6e9, 41)
    place_m = np.arange(-20, 21) * 0.01
    slowness = 2.0 * np.sin(np.radians(dip_deg)) / speed_of_light
    line = np.exp(-2j * np.pi * np.outer(place_m * slowness, frequency_hz))
    values = np.tile(line[None, None], (1, 3, 1, 1))
    wave = as_dataset(
        Imported(values, [0.0], np.arange(3) * 0.01, place_m, np.full(values.shape[:3], 0.2),
                 "wave", frequency_hz=frequency_hz)
    )  # fmt: skip
    return wave if along is Along.X else wave.rename(x="y", y="x")


@pytest.mark.parametrize("along", list(Along))
def test_the_fan_keeps_the_dips_within_it(along):
    middle = {along.value: 20, "frequency": slice(15, None)}
    for dip_deg in (-60.0, -20.0, 20.0, 60.0):
        wave = plane_wave(dip_deg, along)
        low = abs(filter_dips(wave, along, 0.0, 40.0).s21.isel(middle)).mean()
        high = abs(filter_dips(wave, along, 40.0, 90.0).s21.isel(middle)).mean()
        kept, removed = (low, high) if abs(dip_deg) < 40.0 else (high, low)
        assert kept > 0.8, dip_deg
        assert removed < 0.2, dip_deg


def test_the_fan_is_that_of_a_plain_transform():
    made = survey(TARGET, noise_db=-40.0)
    values = made.s21.values[0, 5]
    count = 27  # scipy's next fast length of twice 13 positions
    k = np.fft.fftfreq(count, 0.02)
    expected = np.empty_like(values)
    for place, frequency_hz in enumerate(made.frequency.values):
        line = np.fft.fft(values[:, place], count)
        for one in range(count):
            sine = speed_of_light * abs(k[one]) / (2.0 * frequency_hz)
            dip_deg = np.degrees(np.arcsin(sine)) if sine <= 1.0 else 180.0
            line[one] *= 10.0 <= dip_deg <= 50.0
        expected[:, place] = np.fft.ifft(line)[: len(values)]
    found = filter_dips(made, Along.X, 10.0, 50.0, 0.0).s21.values[0, 5]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_fan_of_all_dips_keeps_what_waves_in_air_can_have():
    made = survey(TARGET)
    kept = filter_dips(filter_dips(made, Along.X), Along.Y)
    inner = {"x": slice(3, 10), "y": slice(3, 10), "frequency": slice(40, None)}
    difference = abs(kept.s21 - made.s21).isel(inner).mean()
    assert float(difference) < 0.05 * float(abs(made.s21).isel(inner).mean())


def test_a_fan_that_makes_no_sense_is_refused():
    empty = survey()
    for wrong in (
        {"least_deg": -1.0},
        {"least_deg": 40.0, "most_deg": 30.0},
        {"most_deg": 91.0},
        {"taper_deg": 46.0},
        {"most_deg": float("nan")},
    ):
        with raises_fault(faults.OPTION):
            filter_dips(empty, **wrong)


def test_the_fan_needs_even_positions_and_all_samples():
    with raises_fault(faults.STEPS):
        filter_dips(survey().isel(x=[0, 1, 3, 4]))
    with raises_fault(faults.STEPS):
        filter_dips(survey().isel(y=[0]), Along.Y)
    with raises_fault(faults.SAMPLES_MISSING):
        filter_dips(holed(survey()))


# Robust PCA


def reference_pursuit(matrix, weight, rounds=400):
    """Return low rank and sparse part by alternating directions with a fixed penalty."""
    penalty = 0.25 * matrix.size / np.abs(matrix).sum()
    sparse, dual = np.zeros_like(matrix), np.zeros_like(matrix)
    for _ in range(rounds):
        u, s, v = np.linalg.svd(matrix - sparse + dual / penalty, full_matrices=False)
        low_rank = (u * np.maximum(s - 1.0 / penalty, 0.0)) @ v
        rest = matrix - low_rank + dual / penalty
        sparse = np.exp(1j * np.angle(rest)) * np.maximum(np.abs(rest) - weight / penalty, 0.0)
        dual = dual + penalty * (matrix - low_rank - sparse)
    return low_rank, sparse


@pytest.mark.parametrize("shape", [(40, 25), (25, 40)])
def test_pursuit_recovers_both_parts_and_is_the_one_of_another_method(shape):
    random = np.random.default_rng(0)

    def normal(*size):
        return random.standard_normal(size) + 1j * random.standard_normal(size)

    low_rank = normal(shape[0], 1) @ normal(1, shape[1])
    sparse = np.where(random.random(shape) < 0.05, 10.0 * normal(*shape), 0.0)
    weight = 1.0 / np.sqrt(max(shape))
    found = principal_component_pursuit(low_rank + sparse, weight)
    reference = reference_pursuit(low_rank + sparse, weight)
    size = np.linalg.norm(low_rank)
    for one, exact, other in zip(found, (low_rank, sparse), reference):
        assert np.linalg.norm(one - other) < 1e-3 * size
        assert np.linalg.norm(one - exact) < 1e-3 * size


def test_robust_pca_removes_a_surface_that_the_mean_does_not():
    made = survey(TARGET, height_m=wavy_m)
    alone = survey(TARGET, height_m=wavy_m, coupling_level_db=-200.0, surface_gain_db=-200.0)
    cleaned = [remove_low_rank(made), remove_background(made, Background.MEAN)]
    left = [float((abs(one.s21 - alone.s21) ** 2).mean()) for one in cleaned]
    assert left[0] < 0.5 * left[1]


def test_robust_pca_keeps_the_place_of_a_target():
    image = image_survey(remove_low_rank(survey(TARGET)), ImageOptions(permittivity=4.0))
    top = np.abs(image.image).argmax(...)
    assert abs(float(image.depth[top["depth"]]) - TARGET.depth_m) < 4e-3
    assert abs(float(image.x[top["x"]]) - TARGET.x_mm / 1e3) < 0.011


def test_robust_pca_refuses_what_it_cannot_do(monkeypatch):
    with raises_fault(faults.OPTION):
        remove_low_rank(survey(), 0.0)
    with raises_fault(faults.SAMPLES_MISSING):
        remove_low_rank(holed(survey()))
    with raises_fault(faults.STEPS):
        remove_low_rank(survey().isel(x=[0], y=[0]))
    monkeypatch.setattr("gpr20_analysis.lazy.available_bytes", lambda: 0)
    with raises_fault(faults.TOO_LARGE):
        remove_low_rank(survey().chunk())


# Time zero and topography


def test_picked_surfaces_are_those_of_the_heights():
    made = survey(TARGET, height_m=wavy_m, coupling_level_db=-60.0)
    picked = pick_time_zero(made).advance.values
    expected = 2.0 * made.height.values / speed_of_light
    assert np.max(np.abs(picked - expected)) < 10e-12


def test_picked_surfaces_contain_a_delay_that_nobody_recorded():
    made = survey(height_m=wavy_m, delay_s=0.2e-9, coupling_level_db=-60.0)
    found = to_time(pick_time_zero(made)).a_scan
    assert int(np.argmax(np.abs(found.values).mean((0, 1, 2)))) == 0
    with raises_fault(faults.STEPS, "only 0 of 169"):
        pick_time_zero(made, within_s=0.05e-9)


def test_a_trace_without_surface_is_placed_by_its_height_and_counted():
    made = survey(height_m=wavy_m, coupling_level_db=-60.0)
    made.height[0, 2, 3] += 0.2
    found = pick_time_zero(made)
    assert float(found.advance[0, 2, 3]) == pytest.approx(
        2.0 * float(made.height[0, 2, 3]) / speed_of_light, abs=10e-12
    )
    assert any("1 traces" in one for one in found.attrs["notes"])


def test_the_first_arrival_is_where_the_envelope_rises():
    made = survey(coupling_level_db=-10.0, coupling_delay_s=0.9e-9)
    found = pick_time_zero(made, Arrival.FIRST, share=0.5)
    in_time = to_time(made, padding=64.0)
    level = np.abs(in_time.a_scan.values[0, 3, 3])
    expected_s = float(in_time.delay[np.argmax(level >= 0.5 * level.max())])
    assert abs(float(found.advance[0, 3, 3]) - expected_s) < 3e-12


def test_picks_change_no_image_and_are_not_made_twice():
    cleaned = remove_background(survey(TARGET))
    moved = pick_time_zero(cleaned, Arrival.FIRST)
    relief = correct_topography(set_time_zero(cleaned), 4.0)
    options = ImageOptions(permittivity=4.0)
    expected = image_survey(cleaned, options).image.values
    for one in (moved, relief):
        found = image_survey(one, options).image.values
        np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
    with raises_fault(faults.STEPS):
        pick_time_zero(moved)
    with raises_fault(faults.STEPS):
        set_time_zero(moved)
    with raises_fault(faults.OPTION):
        pick_time_zero(cleaned, share=0.0)


def test_topography_shows_the_surface_at_its_relief():
    made = survey(height_m=wavy_m, coupling_level_db=-200.0)
    in_time = to_time(correct_topography(set_time_zero(made), 9.0), padding=32.0)
    found_s = in_time.delay.values[np.abs(in_time.a_scan.values[0]).argmax(-1)]
    relief_m = made.height.values[0] - made.height.values[0].min()
    expected_s = 2.0 * 3.0 * relief_m / speed_of_light
    np.testing.assert_allclose(found_s, expected_s, atol=8e-12)


def test_topography_needs_time_zero_and_is_applied_once():
    with raises_fault(faults.STEPS):
        correct_topography(survey(), 4.0)
    moved = correct_topography(set_time_zero(survey()), 4.0)
    with raises_fault(faults.STEPS):
        correct_topography(moved, 4.0)
    with raises_fault(faults.OPTION):
        correct_topography(set_time_zero(survey()), 0.5)


# Display


def test_automatic_gain_divides_by_the_root_mean_square_around_each_sample():
    in_time = to_time(survey(TARGET, noise_db=-90.0))
    step_s = float(in_time.delay[1])
    found = apply_gain(in_time, Gain.AGC, window_s=2e-9).a_scan.values[0, 4, 4]
    trace = in_time.a_scan.values[0, 4, 4]
    width = round(2e-9 / step_s)
    for at in range(0, len(trace), 7):
        first, last = max(at - width // 2, 0), at - width // 2 + width
        around = trace[first:last]
        expected = trace[at] / np.sqrt(np.mean(np.abs(around) ** 2))
        assert abs(found[at] - expected) < 1e-3 * abs(expected) + 1e-6


def test_the_envelope_of_complex_and_of_real_a_scans_is_that_of_the_analytic_signal():
    in_time = to_time(survey(TARGET), padding=16.0)
    found = envelope(in_time)
    np.testing.assert_allclose(found.a_scan.values, np.abs(in_time.a_scan.values))
    real = in_time.assign(a_scan=in_time.a_scan.real)
    expected = np.abs(scipy.signal.hilbert(real.a_scan.values, axis=-1))
    np.testing.assert_allclose(envelope(real).a_scan.values, expected)
    # The band does not begin at zero, so both are the same trace, but for its ends.
    inner = (slice(None), slice(None), slice(None), slice(50, -50))
    atol = 1e-2 * expected.max()
    np.testing.assert_allclose(expected[inner], found.a_scan.values[inner], atol=atol)


def test_the_envelope_is_for_display_only():
    found = envelope(to_time(survey(TARGET)))
    with raises_fault(faults.STEPS):
        image_survey(found, ImageOptions(permittivity=4.0))
    with raises_fault(faults.STEPS):
        envelope(survey())
