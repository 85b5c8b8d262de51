"""Each step on a survey against what it must do to known echoes."""

import json

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from hypothesis import given
from hypothesis import strategies as st

from gpr20_analysis import errors
from gpr20_analysis.dataset import S21_DIMS
from gpr20_analysis.formats.common import to_frequency
from gpr20_analysis.processing.background import Background, remove_background, subtract_coupling
from gpr20_analysis.processing.chain import (
    apply_steps,
    recorded_steps,
    step_from_text,
    text_of,
)
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.processing.sweep import (
    FrequencyGrid,
    select_band,
    select_polarization,
)
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.radar import Window

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


def test_coupling_and_surface_are_removed_and_the_target_stays():
    with_all, alone = survey(TARGET), survey(TARGET, **NONE_DB)
    uncoupled = subtract_coupling(with_all, survey(surface_gain_db=-200.0))
    wanted = survey(TARGET, coupling_level_db=-200.0)
    np.testing.assert_allclose(uncoupled.s21.values, wanted.s21.values, atol=2e-6)
    assert power(with_all) > 20.0 * power(alone)
    for method in Background:
        cleaned = remove_background(with_all, method, width=13)
        # What is left is the target, less what of it is the same everywhere.
        assert 0.2 * power(alone) < power(cleaned) < 1.2 * power(alone), method


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


def test_a_scans_become_the_spectra_that_they_were_made_of():
    measured = survey(TARGET)
    in_time = to_time(measured, Window.NONE, padding=3.0)
    first_hz, *_, last_hz = measured.frequency.values
    found = to_frequency(in_time, first_hz, last_hz, measured.sizes["frequency"])
    np.testing.assert_allclose(found.s21.values, measured.s21.values, atol=1e-9)


def test_parameters_and_references_that_do_not_suit_are_refused():
    measured = survey(TARGET)
    band = select_band(measured, 1.14e9, 1.248e9)
    np.testing.assert_allclose(band.frequency.values, [1.14e9, 1.194e9, 1.248e9])
    named = measured.assign_attrs(survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7")
    for fault, refused in (
        (NOT_ALLOWED, lambda: select_band(measured, 7e9, 8e9)),
        (NOT_ALLOWED, lambda: remove_background(measured, Background.MOVING, width=4)),
        (NOT_ALLOWED, lambda: to_time(measured, padding=0.5)),
        (NOT_ALLOWED, lambda: select_polarization(measured, 45.0)),
        (errors.INPUT, lambda: subtract_coupling(named, named)),
        (errors.INPUT, lambda: subtract_coupling(named, measured.isel(frequency=slice(50)))),
    ):
        with raises_fault(fault):
            refused()


LENGTHS = st.integers(1, 12)


def random_traces(rows, columns, seed, missing):
    """Return random traces, of which some are missing."""
    random = np.random.default_rng(seed)
    s21 = random.standard_normal((1, rows, columns, 3, 2)) @ np.array([1.0, 1j])
    s21[random.random(s21.shape[:3]) < missing] = np.nan
    axes = {name: np.arange(float(count)) for name, count in zip(S21_DIMS, s21.shape)}
    return xr.Dataset({"s21": (S21_DIMS, s21)}, axes)


def means_around(s21, half):
    """Return the mean around each place by its definition."""
    _turns, rows, columns, _frequencies = s21.shape
    found = np.empty_like(s21)
    for row, column in np.ndindex(rows, columns):
        part = s21[
            :, max(0, row - half) : row + half + 1, max(0, column - half) : column + half + 1
        ]
        present = part[np.isfinite(part).all(axis=-1)]
        found[:, row, column] = present.mean(axis=0) if len(present) else 0.0
    return found


@given(LENGTHS, LENGTHS, st.integers(1, 20), st.integers(0, 99), st.sampled_from([0.0, 0.3]))
def test_each_trace_loses_the_mean_of_those_around_it(rows, columns, half, seed, missing):
    survey = random_traces(rows, columns, seed, missing)
    width = 2 * half + 1
    found = remove_background(survey, Background.MOVING, width).s21.values
    s21 = survey.s21.values
    np.testing.assert_allclose(found, s21 - means_around(s21, half), atol=1e-12)
    # A window that is wider than the survey is all of it.
    if not missing:
        wide = remove_background(survey, Background.MOVING, 999_999).s21.values
        expected = remove_background(survey, Background.MEAN).s21.values
        np.testing.assert_allclose(wide, expected, atol=1e-12)


FEW_MM = np.linspace(200.0, 280.0, 5)
FEW = survey_of(scene([point(243.7, 236.2, 0.083)]), FEW_MM, FEW_MM)


def never(path):
    raise AssertionError(f"no step names a survey, but {path} was read")


def test_the_recorded_steps_repeat_the_result(tmp_path):
    read = []
    texts = [f"coupling:reference={tmp_path}/sky.nc", "background:method=moving,width=5"]
    texts += ["time_zero", "time"]
    steps = [step_from_text(text) for text in texts]
    first = apply_steps(FEW, steps, lambda path: read.append(path) or FEW * 0.5)
    assert read == [f"{tmp_path}/sky.nc"]
    recorded = json.loads(first.attrs["processing"])
    assert [one["step"] for one in recorded] == [one.partition(":")[0] for one in texts]
    assert recorded[1] == {"step": "background", "method": "moving", "width": 5}
    again = [step_from_text(text_of(one)) for one in recorded_steps(first)]
    second = apply_steps(FEW, again, lambda path: FEW * 0.5)
    np.testing.assert_array_equal(first.a_scan.values, second.a_scan.values)
    assert recorded_steps(first) == recorded_steps(second)


REFUSED = (
    ("migrate", "background"),
    ("background:wide=2", "'wide'"),
    ("background:width=1.5", "'1.5'"),
    ("time:padding=nan", "'nan'"),
    ("background:method=average", "moving"),
    ("background:method", "'method'"),
    ("background:width=1,width=3", "'width=3'"),
    ("band:start_hz=1e9", "'stop_hz'"),
    ("coupling", "'reference'"),
    ("", "background"),
)


def test_steps_that_make_no_sense_are_refused_with_what_is_allowed():
    for text, shown in REFUSED:
        with raises_fault(errors.STEPS, shown):
            step_from_text(text)
