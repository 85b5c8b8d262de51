"""gpr20 markers, and where the markers of a survey are shown."""

from __future__ import annotations

import csv
import hashlib
import json

import pytest
from survey_kit import POINTS, add_marker, describe_again, make_survey, remove_marker

from gpr20_analysis import load_survey, survey_markers
from gpr20_analysis.commands.main import main
from gpr20_survey.folder.annotating import add_to_survey, annotate
from gpr20_survey.no_clearance import NO_CLEARANCE
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.markers import Marker

NOW, LATER = "2026-11-21T05:10:00.000000Z", "2026-11-21T06:00:00.000000Z"
ONE = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae7", 12.5, 20.0, 80.0, 'raíz, "metal"', "Ana")
OTHER = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae8", 15.0, 10.0)


@pytest.fixture
def folder(tmp_path):
    folder = make_survey(tmp_path, len(POINTS), "finished")
    for marker in (ONE, OTHER):
        add_marker(folder, marker, NOW)
    remove_marker(folder, OTHER, "Luis", LATER)
    return folder


def on_the_earth(folder):
    position = Wgs84Position(4.60283, -74.06514)
    add_to_survey(folder, annotate(Annotation(position=position, heading_deg=0.0)), NOW)


def test_markers_are_listed_and_removed_ones_on_request(folder, capsys):
    assert main(["markers", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    assert lines[1].split()[:3] == ["12", "20", "80"]
    assert lines[1].endswith('raíz, "metal"')
    assert main(["markers", str(folder), "--removed"]) == 0
    assert f"removed {LATER} Luis" in capsys.readouterr().out
    found = survey_markers(load_survey(folder))
    assert [one.same_request(ONE) for one in found.markers] == [True]
    assert found.position is None


@pytest.mark.parametrize("known", [True, False])
def test_csv_and_geojson_hold_metres_and_degrees_where_these_are_known(folder, tmp_path, known):
    if known:
        on_the_earth(folder)
    table, collection = tmp_path / "m.csv", tmp_path / "m.geojson"
    assert main(["markers", str(folder), "-o", str(table), "-o", str(collection)]) == 0
    text = table.read_text("utf-8")
    assert str(NO_CLEARANCE) in text
    (row,) = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    assert (float(row["x_m"]), float(row["y_m"]), float(row["depth_m"])) == (0.0125, 0.02, 0.08)
    assert (row["text"], row["author"], row["time"]) == (ONE.text, "Ana", NOW)
    values = json.loads(collection.read_text("utf-8"))
    (feature,) = values["features"]
    assert values["gpr20"]["warning"] == str(NO_CLEARANCE)
    assert feature["properties"]["x_m"] == 0.0125
    if known:
        longitude_deg, latitude_deg = feature["geometry"]["coordinates"]
        # One degree of latitude is 110.6 km here.
        assert latitude_deg - 4.60283 == pytest.approx(0.02 / 110_600, rel=0.01)
        assert longitude_deg > -74.06514
        assert float(row["latitude_deg"]) == pytest.approx(latitude_deg, abs=1e-8)
    else:
        assert feature["geometry"] is None
        assert row["latitude_deg"] == ""
    checksum = (tmp_path / "m.csv.sha256").read_text()
    assert checksum.split()[0] == hashlib.sha256(table.read_bytes()).hexdigest()


def test_json_is_for_programs(folder, capsys):
    assert main(["markers", str(folder), "--json", "--removed"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert [one["removed_by"] for one in values["markers"]] == ["", "Luis"]


def test_other_endings_are_refused(folder, tmp_path, capsys):
    for name in ("m.txt", "m.gpkg"):
        assert main(["markers", str(folder), "-o", str(tmp_path / name)]) == 3
        assert ".geojson" in capsys.readouterr().err


@pytest.mark.usefixtures("blank_figures")
def test_the_report_and_info_show_markers(folder, tmp_path, capsys):
    report = tmp_path / "r.html"
    assert main(["report", str(folder), "-o", str(report)]) == 0
    assert "raíz, &quot;metal&quot;" in report.read_text("utf-8")
    capsys.readouterr()
    assert main(["info", str(folder)]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [line.split()[-1] for line in printed if line.startswith("markers:")] == ["1"]


def test_damaged_markers_are_a_note_and_refused_by_the_command(tmp_path, capsys):
    folder = make_survey(tmp_path, len(POINTS), "finished")
    describe_again(folder, markers=5)
    survey = load_survey(folder, accept_damaged=True)
    assert "not a list of markers" in str(survey.attrs["notes"])
    assert main(["markers", str(folder), "--accept-damaged"]) == 3
    assert "not a list of markers" in capsys.readouterr().err


def test_info_names_the_survey_that_a_finer_one_refines(tmp_path, capsys):
    folder = make_survey(tmp_path, len(POINTS), "finished")
    coarse = "7c9e6679-7425-40de-944b-e07fc1f90ae7"
    describe_again(folder, refines=coarse)
    main(["info", str(folder), "--accept-damaged"])
    assert coarse in capsys.readouterr().out
