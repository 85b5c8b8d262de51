"""An image does not depend on how many workers its work is cut for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ground_kit import IMAGING_SCENE, survey_of
from hypothesis import given
from hypothesis import strategies as st

from gpr20_analysis import cluster
from gpr20_analysis.cluster import slices
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.background import remove_background

OPTIONS = ImageOptions(
    permittivity=4.0, depth_m=tuple(np.arange(0.03, 0.12, 0.01)), ground=Ground.LEVEL
)


@pytest.fixture
def cut(monkeypatch):
    """Return a function that lets work be cut as for a cluster, and done here."""
    calls = []
    distribute = cluster.distribute

    def counting(function, shared, things, *others):
        calls.append(len(things))
        return distribute(function, shared, things, *others)

    def into(parts):
        monkeypatch.setattr(cluster, "parts", lambda: parts)
        monkeypatch.setattr(cluster, "distribute", counting)
        return calls

    return into


@pytest.fixture(scope="module")
def cleaned():
    survey = remove_background(survey_of(IMAGING_SCENE)).isel(polarization=[0], y=slice(None, -1))
    tilt_m = 0.001 * np.arange(survey.sizes["x"])
    return survey.assign(height=survey.height + tilt_m)


@pytest.mark.parametrize("method", Method)
def test_an_image_in_parts_is_the_same_to_the_last_digit(cleaned, cut, method):
    options = replace(OPTIONS, method=method, ground=Ground.LEVEL)
    expected = image_survey(cleaned, options)
    assert np.abs(expected.image.values).max() > 0.0
    for parts in (2, 64):
        calls = cut(parts)
        np.testing.assert_array_equal(image_survey(cleaned, options).image, expected.image)
        assert min(calls) > 1


@pytest.mark.parametrize("separation_m", [0.0, 0.1])
def test_back_projection_over_uneven_ground_in_parts_is_the_same(cleaned, cut, separation_m):
    options = replace(
        OPTIONS, method=Method.BACK_PROJECTION, ground=Ground.UNEVEN, separation_m=separation_m
    )
    expected = image_survey(cleaned, options).image
    assert not cut(4)
    np.testing.assert_array_equal(image_survey(cleaned, options).image, expected)


def test_the_permittivity_that_is_estimated_in_parts_is_the_same(cut):
    survey = remove_background(survey_of(IMAGING_SCENE, rotations_deg=(0.0,)))
    expected = image_survey(survey, replace(OPTIONS, permittivity=None))
    assert not cut(6)
    assert image_survey(survey, replace(OPTIONS, permittivity=None)).identical(expected)


@given(st.integers(1, 200), st.integers(1, 50))
def test_slices_hold_everything_once_in_order_and_none_is_empty(count, parts):
    cut = slices(count, parts)
    assert [one for part in cut for one in range(count)[part]] == list(range(count))
    assert len(cut) == min(count, parts)
    assert max(part.stop - part.start for part in cut) <= -(-count // len(cut))
