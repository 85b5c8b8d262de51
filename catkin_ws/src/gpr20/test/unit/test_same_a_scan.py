"""Window, RViz picture and analysis show the same A-scan of the same spectrum."""

from __future__ import annotations

import numpy as np
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_analysis.dataset import ATTRIBUTES
from gpr20_analysis.imaging.records import gated_a_scans
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_survey.radar import FrequencyToDelay, Window, delay_kernel
from gpr20_visualization.mid.survey_picture import transform_of

SINGLE = 2e-6


def survey_of(frequency_hz: np.ndarray, s21: np.ndarray) -> xr.Dataset:
    """Return a survey of one trace."""
    dims = ("polarization", "y", "x", "frequency")
    axes = {"polarization": [0.0], "y": [0.0], "x": [0.0], "frequency": frequency_hz}
    traces = {"s21": (dims, s21[np.newaxis, np.newaxis, np.newaxis], ATTRIBUTES["s21"])}
    return xr.Dataset(traces, coords=axes)


@settings(max_examples=draws(12))
@given(
    points=st.integers(21, 801),
    start_hz=st.floats(0.3e9, 2e9),
    band_hz=st.floats(1e9, 5e9),
    seed=st.integers(0, 2**32 - 1),
)
def test_all_parts_show_the_same_a_scan(points, start_hz, band_hz, seed):
    frequency_hz = np.linspace(start_hz, start_hz + band_hz, points)
    random = np.random.default_rng(seed)
    s21 = random.normal(size=points) + 1j * random.normal(size=points)
    survey = survey_of(frequency_hz, s21)
    atol = SINGLE * np.sqrt(points)

    analysed = to_time(survey)
    delay_s, a_scan = analysed["delay"].values, analysed["a_scan"].values[0, 0, 0]
    np.testing.assert_allclose(a_scan, s21 @ delay_kernel(frequency_hz, delay_s), atol=1e-9)

    for shown in (FrequencyToDelay.resolved(frequency_hz, 1000), transform_of(frequency_hz)):
        expected = s21 @ delay_kernel(frequency_hz, shown.delays_s)
        echoes = shown.transform(s21)
        np.testing.assert_allclose(np.abs(echoes), np.abs(expected), atol=atol)
        with_phase = echoes * shown.carrier(shown.delays_s)
        np.testing.assert_allclose(with_phase, expected, atol=2.0 * atol)


@settings(max_examples=draws(6))
@given(points=st.integers(51, 801), delay_s=st.floats(1e-9, 5e-9), window=st.sampled_from(Window))
def test_an_image_reads_the_same_a_scan_within_its_gate(points, delay_s, window):
    frequency_hz = np.linspace(0.6e9, 6e9, points)
    s21 = np.exp(-2j * np.pi * frequency_hz * delay_s)
    sweep = FrequencyGrid(frequency_hz[0], frequency_hz[1] - frequency_hz[0], points)
    a_scans, sample_s = gated_a_scans(s21[np.newaxis], sweep, window, 7e-9)
    near = slice(int((delay_s - 0.2e-9) / sample_s), int((delay_s + 0.2e-9) / sample_s))
    found_s = np.arange(a_scans.shape[1])[near] * sample_s
    expected = s21 @ delay_kernel(frequency_hz, found_s, window)
    np.testing.assert_allclose(a_scans[0, near], expected, atol=0.02)
