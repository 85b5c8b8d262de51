"""gpr20 annotate, and where the annotation of a survey is shown."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from survey_kit import POINTS, describe_again, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.verify import main as gpr20_verify
from gpr20_survey.plan.annotation import Annotation, Wgs84Position, annotation_of

ALL = len(POINTS)
EXAMPLE = Annotation(
    "Lucía Peña", "El Carmen", "wet\nsoil", Wgs84Position(4.60283, -74.06514), name="Carmen 3"
)
NAME = ["--name", "Carmen 3"]
OPTIONS = [*NAME, "--operator", "Lucía Peña", "--site", "El Carmen", "--notes", "wet\nsoil"]
POSITION = ["--position", "4.60283, -74.06514"]


@pytest.fixture
def folder(tmp_path):
    return make_survey(tmp_path, ALL, "finished")


def stored(folder):
    return annotation_of(json.loads((folder / "survey.json").read_text("ascii")))


def annotate(folder, *options):
    return main(["annotate", str(folder), *options])


def test_what_is_given_is_set_and_the_rest_stays(folder, capsys):
    assert annotate(folder, *OPTIONS, *POSITION) == 0
    assert stored(folder) == EXAMPLE
    assert annotate(folder, "--site", "") == 0
    assert stored(folder) == replace(EXAMPLE, site="")
    assert annotate(folder, "--no-position", "--site", "here") == 0
    assert stored(folder) == replace(EXAMPLE, site="here", position=None)
    assert gpr20_verify([str(folder)]) == 0
    capsys.readouterr()
    before = (folder / "survey.json").read_bytes()
    assert annotate(folder) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].endswith("Carmen 3")
    assert [line.split(maxsplit=1)[-1] for line in printed[1:3]] == ["Lucía Peña", "here"]
    assert printed[4] == f"{'':24}soil"
    assert printed[5].endswith("-")
    assert (folder / "survey.json").read_bytes() == before


def test_a_heading_is_set_removed_and_an_attribute(folder, capsys):
    assert annotate(folder, *POSITION, "--heading", "37.5") == 0
    assert stored(folder).heading_deg == 37.5
    assert load_survey(folder).attrs["heading_deg"] == 37.5
    assert "37.5" in capsys.readouterr().out
    assert gpr20_verify([str(folder)]) == 0
    assert annotate(folder, "--no-heading") == 0
    assert stored(folder) == Annotation(position=EXAMPLE.position)
    assert annotate(folder, "--heading", "400") == 3
    error = capsys.readouterr().err
    assert "400 deg" in error and "360 deg" in error


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(-90.0, 90.0), st.floats(-180.0, 180.0))
def test_any_position_on_the_earth_is_stored_as_it_is_given(folder, latitude_deg, longitude_deg):
    assert annotate(folder, f"--position={latitude_deg!r},{longitude_deg!r}") == 0
    assert repr(stored(folder).position) == repr(Wgs84Position(latitude_deg, longitude_deg))


WRONG_VALUES = (
    (["--position", "91,0"], "91 deg"),
    (["--position", "4.6"], "it must be latitude and longitude"),
    (["--position", "4.6,nan"], "longitude is 'nan'; it must be a decimal number"),
    (["--position", "٤,5"], "it must be a decimal number"),
    (["--operator", "a" * 201], "operator has 201 characters; at most 200"),
    (["--site", "a\x07"], r"site holds U+0007 at character 2"),
    ([*POSITION, "--no-position"], "not allowed with"),
)


def test_a_wrong_value_is_refused_and_nothing_changes(folder, capsys):
    before = (folder / "survey.json").read_bytes()
    for options, reason in WRONG_VALUES:
        assert annotate(folder, *options) == 3, options
        assert reason in capsys.readouterr().err
        assert (folder / "survey.json").read_bytes() == before, options


def test_a_survey_that_has_not_ended_is_refused(tmp_path, refusals):
    folder = make_survey(tmp_path, 3, None)
    assert annotate(folder, *OPTIONS) == 3
    assert refusals[-1:] == [faults.SURVEY_RUNS.code]
    assert annotate(folder) == 0


def test_a_damaged_survey_json_is_written_again_from_the_log_before(folder):
    path = folder / "survey.json"
    path.write_bytes(path.read_bytes().replace(b'"y_stop_mm": 20.0', b'"y_stop_mm": 10.0'))
    assert gpr20_verify([str(folder)]) == 2
    assert annotate(folder, *OPTIONS) == 0
    assert stored(folder) == replace(EXAMPLE, position=None)
    assert b'"y_stop_mm": 10.0' not in path.read_bytes()
    assert gpr20_verify([str(folder)]) == 0


def test_what_is_no_survey_is_refused(tmp_path, capsys):
    for name in ("nowhere", ""):
        assert annotate(tmp_path / name, *OPTIONS) == 3
        assert capsys.readouterr().err.startswith("gpr20 annotate: ")


def test_info_and_exports_show_the_annotation(folder, tmp_path, capsys):
    annotate(folder, *OPTIONS, *POSITION, "--heading", "37.5")
    expected = {
        "survey_name": "Carmen 3",
        "operator": "Lucía Peña",
        "site": "El Carmen",
        "survey_notes": "wet\nsoil",
        "latitude_deg": 4.60283,
        "longitude_deg": -74.06514,
    }
    capsys.readouterr()
    assert main(["info", str(folder), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["survey name"] == "Carmen 3"
    assert printed["operator"] == "Lucía Peña"
    assert printed["survey notes"] == "wet\nsoil"
    assert printed["WGS 84 position"] == "4.60283, -74.06514"
    assert printed["heading of Y"] == "37.5 deg"
    output = tmp_path / "s.nc"
    assert main(["export", str(folder), str(output), "--format", "netcdf"]) == 0
    attributes = read_dataset(output).attrs
    assert {key: attributes[key] for key in expected} == expected


def test_an_annotation_that_is_damaged_is_noted_and_does_not_hide_the_survey(folder):
    describe_again(folder, annotation={"operator": 1})
    survey = load_survey(folder)
    assert "operator" not in survey.attrs
    assert any("the annotation in survey.json is not valid" in one for one in survey.attrs["notes"])
