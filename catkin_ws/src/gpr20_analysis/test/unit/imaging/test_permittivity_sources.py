"""How an image knows its permittivity, and what depths say of it."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from hypothesis import given
from hypothesis import strategies as st
from recorded_worlds import real_line

from gpr20_analysis import faults
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_output import permittivity_line, permittivity_range
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.processing.chain import process_survey
from gpr20_survey.radar.soils import ANY_SOIL, Soils

PLACE_MM = np.linspace(100.0, 300.0, 9)


@pytest.fixture(scope="module")
def survey():
    return survey_of(scene([point(173.3, 181.7, 0.113)]), PLACE_MM, PLACE_MM)


def test_a_given_permittivity_is_not_exact(survey):
    image = image_survey(survey, ImageOptions(permittivity=4.0))
    assert image.attrs["permittivity_source"] == "given"
    assert permittivity_range(image) == pytest.approx((3.6, 4.4))
    assert "as given; 3.6 to 4.4 is likely" in str(permittivity_line(image))
    probe = ImageOptions(permittivity=4.0, permittivity_uncertainty=0.02)
    assert permittivity_range(image_survey(survey, probe)) == pytest.approx((3.92, 4.08))


def test_nothing_known_is_an_assumption_that_says_so(survey):
    image = image_survey(survey, ImageOptions())
    assert image.attrs["permittivity_source"] == "assumed"
    assert permittivity_range(image) == (ANY_SOIL.lowest, ANY_SOIL.highest)
    assert "ASSUMED" in str(permittivity_line(image))
    (first, *_) = find_candidates(image).candidates
    # Soil of permittivity 2 would put it so much deeper.
    assert first.depth_uncertainty_m >= first.depth_m * ((5.0 / 2.0) ** 0.5 - 1.0)


@pytest.mark.parametrize("soil", [*Soils])
def test_every_soil_holds_its_own_value_and_is_within_any_soil_or_wetter(soil):
    usual = soil.value
    assert 1.0 < usual.lowest < usual.permittivity < usual.highest
    assert usual.lowest < ANY_SOIL.highest


@given(share=st.floats() | st.sampled_from([0.0, 0.009, 0.91, -0.1]))
def test_an_uncertainty_that_cannot_be_is_refused(share):
    if 0.01 <= share <= 0.9:
        assert ImageOptions(permittivity=4.0, permittivity_uncertainty=share)
        return
    with raises_fault(faults.OPTION):
        ImageOptions(permittivity=4.0, permittivity_uncertainty=share)


def test_the_bars_of_the_real_line_are_found_without_a_permittivity():
    line, bars_m = real_line()
    found = find_candidates(image_survey(process_survey(line, *DEFAULT_STEPS), ImageOptions()))
    listed = [one for one in found.candidates if not one.is_doubtful]
    near = [one for one in listed if np.abs(bars_m - one.x_m).min() < 0.015]
    assert sum(min(abs(one.x_m - bar_m) for one in near) < 0.015 for bar_m in bars_m) >= 13
    # 50 to 80 mm at permittivity 6.
    assert all(abs(one.depth_m - 0.065) < one.depth_uncertainty_m + 0.015 for one in near[:12])


def test_a_survey_without_any_signal_is_refused(survey):
    with pytest.raises(WrongDatasetError, match="zero"):
        image_survey(survey.assign(s21=survey["s21"] * 0.0), ImageOptions())
