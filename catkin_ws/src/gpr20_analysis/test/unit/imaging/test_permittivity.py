"""How an image knows its permittivity, what depths say of it, and a buried reference."""

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from recorded_worlds import AREAS, LINES, UNIANDES, area, line, real_line, truths
from run_seed import LONG

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import DEFAULT_STEPS, ImageOptions
from gpr20_analysis.imaging.permittivity import (
    BuriedReference,
    permittivity_line,
    permittivity_range,
)
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.radar import ANY_SOIL, Soils

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
    soil = image_survey(survey, ImageOptions(soil=Soils.DRY_SAND))
    assert soil.attrs["permittivity_source"] == "typical of the soil"
    assert permittivity_range(soil) == (3, 5)
    with pytest.raises(WrongDatasetError, match="zero"):
        image_survey(survey.assign(s21=survey["s21"] * 0.0), ImageOptions())


def test_nothing_known_is_an_assumption_that_says_so(survey):
    image = image_survey(survey, ImageOptions())
    assert image.attrs["permittivity_source"] == "assumed"
    assert permittivity_range(image) == (ANY_SOIL.lowest, ANY_SOIL.highest)
    assert "ASSUMED" in str(permittivity_line(image))
    (first, *_) = find_candidates(image).candidates
    # Soil of permittivity 2 would put it so much deeper.
    assert first.depth_uncertainty_m >= first.depth_m * ((5.0 / 2.0) ** 0.5 - 1.0)


def test_the_bars_of_the_real_line_are_found_without_a_permittivity():
    line, bars_m = real_line()
    found = find_candidates(image_survey(process_survey(line, *DEFAULT_STEPS), ImageOptions()))
    listed = [one for one in found.candidates if not one.is_doubtful]
    near = [one for one in listed if np.abs(bars_m - one.x_m).min() < 0.015]
    assert sum(min(abs(one.x_m - bar_m) for one in near) < 0.015 for bar_m in bars_m) >= 13
    # 50 to 80 mm at permittivity 6.
    assert all(abs(one.depth_m - 0.065) < one.depth_uncertainty_m + 0.015 for one in near[:12])


def holds(survey, truth, body, y_m=0.0):
    """Return whether the range holds the truth, None if it is refused."""
    reference = BuriedReference(body["x_m"], y_m, body["top_m"])
    options = ImageOptions(buried=reference, separation_m=0.06, ground=Ground.LEVEL)
    try:
        image = image_survey(process_survey(survey, *DEFAULT_STEPS), options, with_echoes=False)
    except WrongDatasetError as error:
        assert error.message.fault is NOT_ALLOWED
        return None
    assert image.attrs["permittivity_source"] == "measured with a buried reference"
    lowest, highest = (image.attrs[f"permittivity_{end}"] for end in ("lowest", "highest"))
    return lowest <= truth["permittivity"] <= highest


def test_metal_under_lines_and_areas_gives_the_permittivity():
    scenes = [line(number) for number in range(0, len(truths(LINES)), 3 if LONG else 6)]
    for name in (UNIANDES, AREAS):
        scenes += [area(name, number) for number in range(len(truths(name)))]
    held = [
        holds(survey, truth, body, body.get("y_m", 0.0))
        for survey, truth in scenes
        for body in truth["bodies"]
        if "metal" in body.get("kind", body.get("name")) or body.get("name") == "plate"
        if body["top_m"] > 0.02
    ]
    accepted = [one for one in held if one is not None]
    assert len(accepted) >= (26 if LONG else 16)
    assert np.mean(accepted) >= 0.95


def test_a_reference_where_nothing_is_outside_or_without_ground_beside_it_is_refused():
    whole = process_survey(area(UNIANDES, 0)[0], *DEFAULT_STEPS)
    cases = [(whole, 0.35, 0.35), (whole, 3.0, 0.2)]
    for rows, columns in ((1, 1), (1, 5), (5, 1), (5, 5)):
        cases.append((whole.isel(y=slice(rows), x=slice(columns)), 0.0, 0.0))
    for survey, x_m, y_m in cases:
        with raises_fault(NOT_ALLOWED):
            image_survey(survey, ImageOptions(buried=BuriedReference(x_m, y_m, 0.1)))


def test_more_than_one_source_and_what_cannot_be_is_refused():
    buried = BuriedReference(0.1, 0.1, 0.1)
    for wrong in (
        *({"permittivity": 4.0, "soil": Soils.CLAY}, {"soil": Soils.CLAY, "buried": buried}),
        *({"buried": BuriedReference(0.1, 0.1, one)} for one in (0.0, 1.5, np.nan)),
        *({"permittivity": 4.0, "permittivity_uncertainty": one} for one in (0.009, 0.91, np.nan)),
    ):
        with raises_fault(NOT_ALLOWED):
            ImageOptions(**wrong)


def test_where_nothing_is_buried_hardly_any_place_gives_a_permittivity():
    accepted = []
    for number in range(0, len(truths(LINES)), 24 if LONG else 48):
        survey, truth = line(number)
        for x_m in np.arange(0.1, 0.9, 0.2):
            if all(abs(body["x_m"] - x_m) > 0.12 for body in truth["bodies"]):
                accepted.append(holds(survey, truth, {"x_m": float(x_m), "top_m": 0.1}) is not None)
    assert len(accepted) > (16 if LONG else 8)
    assert np.mean(accepted) < 0.06
