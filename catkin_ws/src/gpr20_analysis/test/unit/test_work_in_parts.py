"""An image does not depend on how many workers its work is cut for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ground_kit import IMAGING_SCENE, survey_of
from hypothesis import given
from hypothesis import strategies as st

from gpr20_analysis.mid.imaging.image import ImageOptions, Method, image_survey
from gpr20_analysis.mid.imaging.records import Ground
from gpr20_analysis.mid.processing.background import remove_background
from gpr20_analysis.mid.workers import ThisProcess, slices

OPTIONS = ImageOptions(permittivity=4.0, depth_m=tuple(np.arange(0.03, 0.12, 0.01)))


class InParts(ThisProcess):
    """Cuts work as for a cluster, and does it here."""

    def __init__(self, parts):
        self.parts = parts
        self.calls = []

    def map(self, function, shared, things):
        self.calls.append(len(things))
        return super().map(function, shared, things)


@pytest.fixture(scope="module")
def cleaned():
    survey = remove_background(survey_of(IMAGING_SCENE)).isel(polarization=[0], y=slice(None, -1))
    tilt_m = 0.001 * np.arange(survey.sizes["x"])
    return survey.assign(height=survey.height + tilt_m)


@pytest.mark.parametrize("parts", [2, 5, 64])
@pytest.mark.parametrize("method", Method)
def test_an_image_in_parts_is_the_same_to_the_last_digit(cleaned, method, parts):
    workers = InParts(parts)
    options = replace(OPTIONS, method=method)
    expected = image_survey(cleaned, options)
    assert np.abs(expected.image.values).max() > 0.0
    np.testing.assert_array_equal(image_survey(cleaned, options, workers).image, expected.image)
    assert min(workers.calls) > 1


@pytest.mark.parametrize("separation_m", [0.0, 0.1])
def test_back_projection_over_uneven_ground_in_parts_is_the_same(cleaned, separation_m):
    options = replace(
        OPTIONS, method=Method.BACK_PROJECTION, ground=Ground.UNEVEN, separation_m=separation_m
    )
    expected = image_survey(cleaned, options).image
    np.testing.assert_array_equal(image_survey(cleaned, options, InParts(4)).image, expected)


def test_the_permittivity_that_is_estimated_in_parts_is_the_same():
    survey = remove_background(survey_of(IMAGING_SCENE))
    expected = image_survey(survey, replace(OPTIONS, permittivity=None))
    found = image_survey(survey, replace(OPTIONS, permittivity=None), InParts(6))
    assert found.identical(expected)


@given(st.integers(1, 200), st.integers(1, 50))
def test_slices_hold_everything_once_in_order_and_none_is_empty(count, parts):
    cut = slices(count, parts)
    assert [one for part in cut for one in range(count)[part]] == list(range(count))
    assert len(cut) == min(count, parts)
    assert max(part.stop - part.start for part in cut) <= -(-count // len(cut))
