"""The Kirchhoff methods as methods of gpr20: conditions and candidates."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from noise_kit import errors_in_uncertainties

from gpr20_analysis import faults
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.records import Ground
from gpr20_foreign_formats.kirchhoff import KIRCHHOFF, KIRCHHOFF_2D

METHODS = [KIRCHHOFF, KIRCHHOFF_2D]
QUIET = {"coupling_level_db": -200.0, "surface_gain_db": -200.0}


def test_the_target_is_near_its_place():
    target = point(173.3, 181.7, 0.1134)
    survey = survey_of(scene([target], **QUIET), rotations_deg=(0.0,))
    image = image_survey(survey, ImageOptions(KIRCHHOFF, 4.0))
    assert image.image.dtype == np.float64
    found = find_candidates(image).candidates[0]
    error_m = (
        found.x_m - target.x_mm / 1e3,
        found.y_m - target.y_mm / 1e3,
        found.depth_m - target.depth_m,
    )
    assert np.linalg.norm(error_m) < 0.02
    # The depth step of this method is the sample time times the speed in the soil.
    sample_s = 1.0 / (2 * round(6e9 / 54e6) * 54e6)
    assert np.diff(image.depth)[0] == pytest.approx(sample_s * 1.5e8, rel=0.01)


@pytest.mark.parametrize("method", METHODS)
def test_the_positions_of_the_survey_are_kept(method):
    with raises_fault(faults.OPTION, "use --grid-step with --method phase-shift"):
        ImageOptions(method, 4.0, grid_step_m=0.01)


def test_uneven_ground_is_refused():
    with raises_fault(faults.METHOD, "needs --method back-projection"):
        ImageOptions(KIRCHHOFF, 4.0, ground=Ground.UNEVEN)


@pytest.mark.parametrize("method", METHODS)
def test_candidates_lie_where_they_are_within_their_uncertainties(method):
    assert errors_in_uncertainties(method).max() < 1.6
