"""The permittivity by a buried reference, on ground that was computed by Maxwell's equations."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from recorded_worlds import AREAS, LINES, UNIANDES, area, line, truths

from gpr20_analysis import faults
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.imaging.permittivity.buried_reference import BuriedReference
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey
from gpr20_survey.radar.soils import Soils


def holds(survey, truth, body, y_m=0.0):
    """Return whether the range holds the truth, None if it is refused."""
    reference = BuriedReference(body["x_m"], y_m, body["top_m"])
    options = ImageOptions(buried=reference, separation_m=0.06, ground=Ground.LEVEL)
    try:
        image = image_survey(process_survey(survey, *DEFAULT_STEPS), options, with_echoes=False)
    except WrongDatasetError as error:
        assert error.message.fault is faults.NO_PERMITTIVITY
        return None
    assert image.attrs["permittivity_source"] == "measured with a buried reference"
    lowest, highest = (image.attrs[f"permittivity_{end}"] for end in ("lowest", "highest"))
    return lowest <= truth["permittivity"] <= highest


def test_metal_under_lines_gives_the_permittivity():
    held = []
    for number, truth in enumerate(truths(LINES)):
        metal = [body for body in truth["bodies"] if "metal" in body["kind"]]
        held += [holds(*line(number), body) for body in metal if body["top_m"] > 0.02]
    accepted = [one for one in held if one is not None]
    assert len(accepted) >= 60
    assert np.mean(accepted) >= 0.95


@pytest.mark.parametrize("name", [UNIANDES, AREAS])
def test_flat_metal_under_areas_gives_it_too(name):
    accepted = 0
    for number, truth in enumerate(truths(name)):
        survey, _ = area(name, number)
        for body in truth["bodies"]:
            if body["name"] in ("plate", "metal disc"):
                found = holds(survey, truth, body, body["y_m"])
                assert found in (True, None), (number, body)
                accepted += found is True
    assert accepted >= 3


def test_a_reference_where_nothing_is_or_outside_is_refused():
    survey, _ = area(UNIANDES, 0)
    for x_m, y_m in ((0.35, 0.35), (3.0, 0.2)):
        options = ImageOptions(buried=BuriedReference(x_m, y_m, 0.1))
        with raises_fault(faults.NO_PERMITTIVITY):
            image_survey(process_survey(survey, *DEFAULT_STEPS), options)


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (2, 2), (1, 5), (5, 1), (5, 5)])
def test_a_survey_without_ground_beside_the_reference_is_refused(rows, columns):
    survey, _ = area(UNIANDES, 0)
    survey = process_survey(survey, *DEFAULT_STEPS).isel(y=slice(rows), x=slice(columns))
    with raises_fault(faults.NO_PERMITTIVITY):
        image_survey(survey, ImageOptions(buried=BuriedReference(0.0, 0.0, 0.1)))


@pytest.mark.parametrize("depth_m", [0.0, -0.1, 1.5, np.nan])
def test_a_depth_that_cannot_be_is_refused(depth_m):
    with raises_fault(faults.OPTION):
        ImageOptions(buried=BuriedReference(0.1, 0.1, depth_m))


def test_more_than_one_source_is_refused():
    for given in ({"permittivity": 4.0, "soil": Soils.CLAY}, {"soil": Soils.CLAY, "buried":
                  BuriedReference(0.1, 0.1, 0.1)}):  # fmt: skip
        with raises_fault(faults.OPTION):
            ImageOptions(**given)


def test_a_chosen_soil_has_its_usual_range():
    survey, _ = line(0)
    image = image_survey(process_survey(survey, *DEFAULT_STEPS), ImageOptions(soil=Soils.DRY_SAND))
    assert image.attrs["permittivity_source"] == "typical of the soil"
    assert [image.attrs[f"permittivity{end}"] for end in ("_lowest", "", "_highest")] == [3, 4, 5]


def test_where_nothing_is_buried_hardly_any_place_gives_a_permittivity():
    accepted = []
    for number in range(0, len(truths(LINES)), 8):
        survey, truth = line(number)
        for x_m in np.arange(0.1, 0.9, 0.2):
            if all(abs(body["x_m"] - x_m) > 0.12 for body in truth["bodies"]):
                accepted.append(holds(survey, truth, {"x_m": float(x_m), "top_m": 0.1}) is not None)
    assert len(accepted) > 50
    assert np.mean(accepted) < 0.06
