"""Dewow, f-k filter, robust PCA, time zero, topography, gain and envelope against references."""

import numpy as np
import scipy.signal
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from scipy.constants import speed_of_light

from gpr20_analysis import faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.display import Gain, apply_gain, envelope
from gpr20_analysis.processing.filters import Along, dewow, filter_dips
from gpr20_analysis.processing.robust_pca import principal_component_pursuit, remove_low_rank
from gpr20_analysis.processing.time_zero import Arrival, correct_topography, pick_time_zero
from gpr20_common.faults import NOT_ALLOWED
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


def test_dewow_of_spectra_and_of_a_scans_is_the_trace_less_its_running_mean():
    in_time = to_time(survey(TARGET), Window.NONE, padding=64.0)
    trace, step_s = in_time.a_scan.values[0, 6, 6], float(in_time.delay[1])
    kernel = np.ones(2 * int(0.5e-9 / step_s) + 1)
    mean = np.convolve(trace, kernel, "same") / np.convolve(np.ones(len(trace)), kernel, "same")
    np.testing.assert_allclose(dewow(in_time, 1e-9).a_scan.values[0, 6, 6], trace - mean, atol=1e-9)
    found = to_time(dewow(survey(TARGET), 1e-9), Window.NONE, padding=64.0).a_scan.values[0, 6, 6]
    width = 2 * round(1e-9 / step_s / 2.0) + 1
    inner = slice(width, -width)
    expected = (trace - np.convolve(trace, np.ones(width) / width, "same"))[inner]
    np.testing.assert_allclose(found[inner], expected, atol=0.02 * abs(expected).max())


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


def test_what_makes_no_sense_is_refused(monkeypatch):
    empty = survey()
    moved = correct_topography(set_time_zero(empty), 4.0)
    wrong_fans = ({"least_deg": -1.0}, {"least_deg": 40.0, "most_deg": 30.0}, {"most_deg": 91.0})
    for fault, refused in (
        *((NOT_ALLOWED, lambda one=one: filter_dips(empty, **one)) for one in wrong_fans),
        (NOT_ALLOWED, lambda: filter_dips(empty, taper_deg=46.0)),
        (faults.STEPS, lambda: filter_dips(empty.isel(x=[0, 1, 3, 4]))),
        (faults.INPUT, lambda: filter_dips(holed(survey()))),
        (NOT_ALLOWED, lambda: dewow(empty, float("nan"))),
        (NOT_ALLOWED, lambda: dewow(to_time(empty), 1e-13)),
        (NOT_ALLOWED, lambda: remove_low_rank(empty, 0.0)),
        (faults.INPUT, lambda: remove_low_rank(holed(survey()))),
        (faults.STEPS, lambda: remove_low_rank(empty.isel(x=[0], y=[0]))),
        (faults.STEPS, lambda: pick_time_zero(moved)),
        (NOT_ALLOWED, lambda: pick_time_zero(empty, share=0.0)),
        (faults.STEPS, lambda: correct_topography(moved, 4.0)),
        (NOT_ALLOWED, lambda: correct_topography(set_time_zero(empty), 0.5)),
        (faults.STEPS, lambda: envelope(empty)),
        (faults.STEPS, lambda: image_survey(envelope(to_time(empty)), ImageOptions())),
    ):
        with raises_fault(fault):
            refused()
    monkeypatch.setattr("gpr20_analysis.work.available_bytes", lambda: 0)
    with raises_fault(faults.TOO_LARGE):
        remove_low_rank(empty)


def test_pursuit_recovers_both_parts():
    shape = (40, 25)
    random = np.random.default_rng(0)

    def normal(*size):
        return random.standard_normal(size) + 1j * random.standard_normal(size)

    low_rank = normal(shape[0], 1) @ normal(1, shape[1])
    sparse = np.where(random.random(shape) < 0.05, 10.0 * normal(*shape), 0.0)
    weight = 1.0 / np.sqrt(max(shape))
    found = principal_component_pursuit(low_rank + sparse, weight)
    for one, exact in zip(found, (low_rank, sparse)):
        assert np.linalg.norm(one - exact) < 1e-3 * np.linalg.norm(low_rank)


def test_robust_pca_removes_a_surface_that_the_mean_does_not():
    made = survey(TARGET, height_m=wavy_m)
    alone = survey(TARGET, height_m=wavy_m, coupling_level_db=-200.0, surface_gain_db=-200.0)
    cleaned = [remove_low_rank(made), remove_background(made, Background.MEAN)]
    left = [float((abs(one.s21 - alone.s21) ** 2).mean()) for one in cleaned]
    assert left[0] < 0.5 * left[1]


def test_picked_surfaces_are_those_of_the_heights_and_hold_a_delay_that_nobody_recorded():
    made = survey(height_m=wavy_m, coupling_level_db=-60.0)
    made.height[0, 2, 3] += 0.2  # no surface is there: its height places it
    found = pick_time_zero(made)
    expected_s = 2.0 * made.height.values / speed_of_light
    assert np.max(np.abs(found.advance.values - expected_s)) < 10e-12
    assert any("1 traces" in one for one in found.attrs["notes"])
    made = survey(height_m=wavy_m, delay_s=0.2e-9, coupling_level_db=-60.0)
    found = to_time(pick_time_zero(made)).a_scan
    assert int(np.argmax(np.abs(found.values).mean((0, 1, 2)))) == 0
    with raises_fault(faults.STEPS, "only 0 of 169"):
        pick_time_zero(made, within_s=0.05e-9)


def test_picks_and_topography_change_no_image_and_show_the_surface_at_its_relief():
    cleaned = remove_background(survey(TARGET))
    options = ImageOptions(permittivity=4.0)
    expected = image_survey(cleaned, options).image.values
    relief = correct_topography(set_time_zero(cleaned), 4.0)
    for one in (pick_time_zero(cleaned, Arrival.FIRST), relief):
        found = image_survey(one, options).image.values
        np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
    made = survey(height_m=wavy_m, coupling_level_db=-200.0)
    in_time = to_time(correct_topography(set_time_zero(made), 9.0), padding=32.0)
    found_s = in_time.delay.values[np.abs(in_time.a_scan.values[0]).argmax(-1)]
    relief_m = made.height.values[0] - made.height.values[0].min()
    np.testing.assert_allclose(found_s, 2.0 * 3.0 * relief_m / speed_of_light, atol=8e-12)


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
