from __future__ import annotations

import json
from pathlib import Path

from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata

DATA = Path("/data")
COORDINATE = st.floats(-10_000, 10_000)


def test_a_survey_folder_is_named_by_time_and_id():
    folder = survey_folder.survey_folder(DATA, SURVEY, STARTED_US)
    assert folder == DATA / "20260921T141320_0f8fad5b"


@each_case(
    "survey_id",
    ["", "..", "../../../../etc", "/etc/passwd", SURVEY.upper(), SURVEY + "\n", SURVEY + "/..",
     "0f8fad5b-d9cb-469f-a165-7086772895\u0660e", "{" + SURVEY + "}", SURVEY.replace("-", "")],
)  # fmt: skip
def test_an_id_that_is_no_uuid_never_becomes_a_path(survey_id):
    with raises_fault("storage.request_refused", error=SurveyRefusedError):
        survey_folder.survey_folder(DATA, survey_id, STARTED_US)


@each_case("started_us", [0, 1, 1_000_000_000_000_000])
def test_a_survey_of_1970_is_refused(started_us):
    with raises_fault("clock.wrong", error=SurveyRefusedError):
        survey_folder.survey_folder(DATA, SURVEY, started_us)


def test_a_trace_file_is_named_by_index_and_coordinates():
    trace = make_trace(123, x_coord_mm=50.0, y_coord_mm=-0.001, z_coord_deg=-90.0)
    assert survey_folder.trace_file_name(trace) == "000123_X0050.00_Y0000.00_Z-090.00.json"


@given(st.integers(0, 999_999), COORDINATE, COORDINATE, COORDINATE)
def test_a_trace_file_name_is_one_plain_name_that_sorts_by_index(index, x_mm, y_mm, z_deg):
    trace = make_trace(1, x_coord_mm=x_mm, y_coord_mm=y_mm, z_coord_deg=z_deg)
    name = survey_folder.trace_file_name(trace)
    assert Path(name).name == name
    assert name.startswith("000001_X")
    assert name.endswith(".json")


@each_case(
    "text, shown",
    [
        ("", ()),
        ("[1]", ("list",)),
        ("null", ("NoneType",)),
        ('{"a": NaN}', ("NaN",)),
        ('{"a": 1e999}', ()),
        ('{"a": ' + "[" * 40 + "]" * 40 + "}", (32,)),
        ("[" * 200_000, (32,)),
        ('{"a":' * 100_000, (32,)),
        ('{"\\"": ' * 33, (32,)),
        ('{"a": "' + "x" * (1 << 20) + '"}', (1048576,)),
    ],
)
def test_metadata_that_are_no_sane_object_are_refused(text, shown):
    with raises_fault("storage.request_refused", *shown, error=SurveyRefusedError):
        survey_metadata.parse_metadata(text)


def test_brackets_in_texts_are_no_nesting():
    values = {"a": "[{" * 100 + '\\"[' * 100, "b\\": 2, "c": [[]] * 100}
    assert survey_metadata.parse_metadata(json.dumps(values)) == values


def test_metadata_may_not_contradict_the_storage():
    with raises_fault("storage.request_refused", "started", error=SurveyRefusedError):
        survey_metadata.combine({"started": "yesterday"}, {"started": "today"})


def test_metadata_are_kept_beside_the_own_entries():
    combined = survey_metadata.combine({"b": [1], "ended": None}, {"ended": None})
    assert combined == {"ended": None, "b": [1]}


def test_odd_texts_survive_in_strict_ascii_json():
    values = {"place": "Cañón \ud800 \u2028"}
    assert json.loads(survey_metadata.encode(values)) == values
