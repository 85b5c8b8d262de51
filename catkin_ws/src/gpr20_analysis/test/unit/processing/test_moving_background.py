"""The mean in a moving window, on grids and single lines of every length."""

from __future__ import annotations

import numpy as np
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_analysis.dataset import S21_DIMS
from gpr20_analysis.processing.background import Background, remove_background

LENGTHS = st.integers(1, 12)


def survey_of(rows, columns, seed, missing):
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


@settings(max_examples=200, deadline=None)
@given(LENGTHS, LENGTHS, st.integers(1, 20), st.integers(0, 99), st.sampled_from([0.0, 0.3]))
def test_each_trace_loses_the_mean_of_those_around_it(rows, columns, half, seed, missing):
    survey = survey_of(rows, columns, seed, missing)
    width = 2 * half + 1
    found = remove_background(survey, Background.MOVING, width).s21.values
    s21 = survey.s21.values
    np.testing.assert_allclose(found, s21 - means_around(s21, half), atol=1e-12)
    turned = survey.rename(x="y", y="x").transpose(*S21_DIMS)
    found_turned = remove_background(turned, Background.MOVING, width).s21
    np.testing.assert_allclose(found_turned.values.swapaxes(1, 2), found, atol=1e-12)
    lazy = remove_background(survey.chunk({"y": 2}), Background.MOVING, width).s21.values
    np.testing.assert_allclose(lazy, found, atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(LENGTHS, LENGTHS, st.integers(0, 99))
def test_a_window_that_is_wider_than_the_survey_is_all_of_it(rows, columns, seed):
    survey = survey_of(rows, columns, seed, 0.0)
    for width in (2 * max(rows, columns) + 1, 999_999):
        found = remove_background(survey, Background.MOVING, width).s21.values
        expected = remove_background(survey, Background.MEAN).s21.values
        np.testing.assert_allclose(found, expected, atol=1e-12)
