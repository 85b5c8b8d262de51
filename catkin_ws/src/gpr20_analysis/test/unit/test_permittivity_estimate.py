"""The estimate of the permittivity by focus, and its honesty."""

from __future__ import annotations

import numpy as np
import pytest
from ground_kit import IMAGING_SCENE, point, scene, survey_of

from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_output import permittivity_line
from gpr20_analysis.processing.background import remove_background

POINTS = (point(173.3, 181.7, 0.113), point(318.9, 207.4, 0.071), point(236.2, 322.8, 0.16))


@pytest.mark.parametrize("permittivity", [3.0, 5.0, 9.0])
def test_small_targets_tell_the_permittivity_within_a_tenth(permittivity):
    survey = survey_of(scene(POINTS, permittivity), rotations_deg=(0.0,))
    image = image_survey(remove_background(survey), ImageOptions())
    assert image.attrs["permittivity"] == pytest.approx(permittivity, rel=0.1)
    assert image.attrs["permittivity_lowest"] < permittivity < image.attrs["permittivity_highest"]


def test_extended_targets_are_within_what_is_said():
    image = image_survey(remove_background(survey_of(IMAGING_SCENE)), ImageOptions())
    assert image.attrs["permittivity_lowest"] < 5.0 < image.attrs["permittivity_highest"]
    assert "ESTIMATED" in str(permittivity_line(image))


def test_nothing_to_focus_is_refused():
    survey = survey_of(scene([point(240.0, 240.0, 0.1)]), rotations_deg=(0.0,))
    empty = survey.assign(s21=survey.s21 * 0.0)
    with pytest.raises(WrongDatasetError, match="no echo can be seen"):
        image_survey(empty, ImageOptions())


def test_given_permittivity_is_not_called_estimated():
    survey = survey_of(scene(POINTS[:1]), np.linspace(100, 300, 9), np.linspace(100, 300, 9))
    image = image_survey(survey, ImageOptions(permittivity=4.0))
    assert image.attrs["permittivity_source"] == "given"
    assert "as given" in str(permittivity_line(image))
    assert np.isclose(image.attrs["permittivity"], 4.0)
