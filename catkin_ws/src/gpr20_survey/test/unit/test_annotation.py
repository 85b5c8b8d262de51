"""What people add to a survey, and what was found: it comes out as it went in, or is refused."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest
from annotation_examples import EXAMPLE, REFUSED, REFUSED_POSITIONS, annotations
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_survey.folder import survey_metadata
from gpr20_survey.plan.annotation import (
    EMPTY,
    Annotation,
    Wgs84Position,
    annotation_of,
    from_fields,
    position_from_text,
)
from gpr20_survey.plan.markers import Found, What, found_of, present


@given(annotations)
def test_an_annotation_comes_out_of_the_fields_of_a_message_as_it_went_in(annotation):
    assert repr(from_fields(SimpleNamespace(**annotation.fields()))) == repr(annotation)


@each_case("changes, shown", REFUSED)
def test_a_text_that_cannot_be_shown_or_a_heading_that_is_none_is_refused(changes, shown):
    with raises_fault("value.not_allowed", *shown, error=InvalidValueError):
        Annotation(**changes)


@each_case("numbers, shown", REFUSED_POSITIONS)
def test_a_position_that_is_not_on_the_earth_is_refused(numbers, shown):
    with raises_fault("value.not_allowed", *shown, error=InvalidValueError):
        Wgs84Position(*numbers)


def test_a_survey_without_an_annotation_has_an_empty_one():
    assert annotation_of({"format": "gpr20-survey/1"}) == EMPTY == Annotation()


@each_case(
    "values",
    [
        None,
        {**EXAMPLE.values(), "other": 1},
        {**EXAMPLE.values(), "heading_deg": "12"},
        {**EXAMPLE.values(), "notes": "half \ud83d"},
        {**EXAMPLE.values(), "position": {"latitude_deg": 1.0}},
        {**EXAMPLE.values(), "operator": 1},
    ],
)
def test_an_entry_of_survey_json_that_is_none_is_refused(values):
    with pytest.raises(InvalidValueError):
        annotation_of({"annotation": values})


def test_empty_fields_take_the_defaults_but_name_and_notes_have_none():
    place = Wgs84Position(1.0, 2.0)
    defaults = Annotation("robot's", "its site", "of another survey", place, name="another")
    assert EMPTY.with_defaults(defaults) == Annotation("robot's", "its site", "", defaults.position)
    assert EXAMPLE.with_defaults(defaults) == EXAMPLE
    assert EXAMPLE.with_defaults(EMPTY) == EXAMPLE


@given(annotations, st.floats(0.0, 360.0))
def test_a_heading_is_stored(annotation, heading_deg):
    headed = replace(annotation, heading_deg=heading_deg)
    description = json.loads(survey_metadata.encode({"annotation": headed.values()}))
    assert annotation_of(description) == headed


@each_case("text", ["4.5,-74.25", "4.5; -74.25", "4,5; -74,25", " 4.50 , -74.250 ", "4,5;-74.25"])
def test_a_position_is_read_with_decimal_points_and_commas(text):
    assert position_from_text(text) == Wgs84Position(4.5, -74.25)


TIME = "2026-11-27T03:00:00.000000+00:00"
FOUND = Found(What.SCRAP, "C03", "a" * 64, 10.0, 20.0, "Ana", TIME)
TEXT = st.text(st.characters(blacklist_categories=["Cc", "Cs", "Zl", "Zp", "Cf"]), max_size=20)
MM = st.floats(-10_000.0, 10_000.0)
DEPTH = st.none() | st.floats(0.0, 10_000.0)


@given(st.sampled_from(What), MM, MM, TEXT.filter(bool), DEPTH, TEXT)
def test_any_record_comes_back_from_json(what, x_mm, y_mm, who, depth_mm, notes):
    one = Found(what, "C01", "b" * 64, x_mm, y_mm, who, TIME, depth_mm, "", notes)
    assert found_of(json.loads(json.dumps(one.values()))) == one


@each_case(
    "change",
    [
        *({"who": ""}, {"who": "a\nb"}, {"notes": "x" * 501}, {"x_mm": float("nan")}),
        *({"y_mm": 1e5}, {"depth_mm": -1.0}, {"candidate": "3"}, {"list_sha256": "A" * 64}),
        *({"photo": "../../etc/passwd"}, {"photo": "a" * 64 + ".exe"}, {"time": "yesterday"}),
    ],
)
def test_a_value_that_is_not_allowed_is_refused(change):
    with pytest.raises(InvalidValueError):
        replace(FOUND, **change)


def test_a_later_record_replaces_one_of_the_same_candidate_of_the_same_list_only():
    later = replace(FOUND, what=What.DEVICE)
    other_list = replace(FOUND, list_sha256="b" * 64)
    other = replace(FOUND, candidate="C04")
    assert present([FOUND, other_list, other, later]) == [later, other_list, other]
