"""The settings of the VNA from the traces to summary and exports."""

from __future__ import annotations

import json

import pytest
from survey_kit import make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.report.summary import summary_of
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

EXPECTED = {"if_bandwidth_hz": 1000.0, "averages": 4, "output_power": "HIGH"}
UNKNOWN = {"analyzer": AnalyzerSettings()}
OTHER = {"analyzer": AnalyzerSettings(20.0, 1, "LOW")}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("settings"), 18, "finished")


def test_the_settings_are_attributes_of_the_dataset(folder):
    for source in ("", "survey.bag", "survey.mcap"):
        attributes = load_survey(folder / source).attrs
        assert {name: attributes[name] for name in EXPECTED} == EXPECTED, source


def test_info_shows_them(folder, capsys):
    assert main(["info", str(folder), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["IF bandwidth"], shown["averages"], shown["output power"]) == (
        "1000 Hz",
        "4",
        "HIGH",
    )


def test_the_summary_names_each_analyzer_of_the_survey(folder):
    survey = load_survey(folder)
    for analyzers, shown in (
        ([{"identity": "A", "from_index": 0}, {"identity": "B", "from_index": 7}], ["B"]),
        ([{"identity": "A", "from_index": 0}], []),
        ([None, 3], []),
        ("x", []),
        (None, []),
    ):
        described = {"instrument": {"identity": "A"}, "report": {"analyzers": analyzers}}
        survey.attrs["survey_json"] = json.dumps(described)
        rows = {str(title): str(text) for title, text in summary_of(survey)}
        assert rows["VNA"] == "A", analyzers
        later = [text for title, text in rows.items() if title == "VNA from trace 7"]
        assert later == shown, analyzers


def test_exports_hold_them(folder, tmp_path):
    for name, file_format in (("s.nc", "netcdf"), ("ts", "touchstone")):
        assert main(["export", str(folder), str(tmp_path / name), "--format", file_format]) == 0
    attributes = read_dataset(tmp_path / "s.nc").attrs
    assert {name: attributes[name] for name in EXPECTED} == EXPECTED
    first = sorted((tmp_path / "ts").iterdir())[0]
    assert "if_bandwidth_hz 1000.0, averages 4, output_power HIGH" in first.read_text()


def test_samples_that_do_not_say_do_not_count(tmp_path):
    early = make_survey(tmp_path, 9, "stopped", dict.fromkeys(range(9), UNKNOWN))
    assert not load_survey(early).attrs.keys() & EXPECTED.keys()
    resumed = make_survey(tmp_path / "resumed", 9, "stopped", dict.fromkeys(range(7), UNKNOWN))
    attributes = load_survey(resumed).attrs
    assert {name: attributes[name] for name in EXPECTED} == EXPECTED
    assert not any("different settings" in note for note in attributes["notes"])


def test_samples_with_different_settings_are_a_note(tmp_path):
    attributes = load_survey(make_survey(tmp_path, 9, "stopped", {5: OTHER, 7: OTHER})).attrs
    assert {name: attributes[name] for name in EXPECTED} == EXPECTED
    (note,) = [one for one in attributes["notes"] if "different settings" in one]
    assert "7 with IF bandwidth 1000 Hz, averages 4, output power HIGH, 2 with others" in note
