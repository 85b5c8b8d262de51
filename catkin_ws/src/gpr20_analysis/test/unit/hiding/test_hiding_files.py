"""The map of where a target could hide as files, and the commands that read and write them."""

from __future__ import annotations

import hashlib
import json
import sqlite3
import struct
from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault

from gpr20_analysis import faults, hiding_figure, read_hiding, write_hiding
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import ExportError, UnreadableFileError
from gpr20_analysis.sample.sample_survey import sample_survey
from gpr20_survey.results.area_position import AreaPosition

FAST = ["--permittivity", "5", "--rounds", "2", "--target-depths", "30", "150"]


@pytest.fixture(scope="module")
def survey():
    return str(sample_survey())


@pytest.fixture(scope="module")
def written(survey, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hiding")
    outputs = [one for name in ("a.json", "a.gpkg", "a.png")
               for one in ("-o", str(folder / name))]  # fmt: skip
    assert main(["hiding", survey, *FAST, *outputs]) == DONE
    return folder


@pytest.fixture(scope="module")
def found(written):
    return read_hiding(written / "a.json")


def test_each_file_has_its_checksum(written):
    for name in ("a.json", "a.gpkg"):
        digest = hashlib.sha256((written / name).read_bytes()).hexdigest()
        assert (written / f"{name}.sha256").read_text() == f"{digest}  {name}\n"
    assert (written / "a.png").read_bytes().startswith(b"\x89PNG")


def test_geopackage_has_a_polygon_around_each_place(written, found):
    with sqlite3.connect(str(written / "a.gpkg")) as database:
        kind = database.execute("SELECT geometry_type_name FROM gpkg_geometry_columns").fetchone()
        rows = database.execute("SELECT geom, x_m, y_m, found_30mm FROM hiding").fetchall()
        warning = database.execute(
            "SELECT value FROM hiding_facts WHERE name = 'warning'"
        ).fetchone()[0]
    assert kind == ("POLYGON",) and len(rows) == found.missed_m.size
    assert "holds for this target only" in warning and "SIMULATED" in warning
    assert [row[-1] for row in rows] == pytest.approx(found.share[0].ravel().tolist(), abs=1e-6)
    for geometry, x_m, y_m, _share in rows:
        order, number, rings, corners = struct.unpack_from("<BIII", geometry, 8)
        assert (order, number, rings, corners) == (1, 3, 1, 5)
        places = np.array(struct.unpack_from("<10d", geometry, 21)).reshape(5, 2)
        assert np.array_equal(places[0], places[-1])
        assert places[:4].mean(axis=0) == pytest.approx((x_m, y_m))


def test_geojson_needs_a_place_on_the_earth_and_is_there(found, tmp_path):
    with raises_fault(faults.NO_POSITION):
        write_hiding(found, tmp_path / "a.geojson")
    placed = replace(found, position=AreaPosition(4.6, -74.1, 90.0))
    write_hiding(placed, tmp_path / "a.geojson")
    features = json.loads((tmp_path / "a.geojson").read_text(encoding="utf-8"))["features"]
    assert len(features) == found.missed_m.size
    for feature in features:
        ring = np.array(feature["geometry"]["coordinates"][0])
        assert np.abs(ring - [-74.1, 4.6]).max() < 1e-4
        values = feature["properties"]
        middle = placed.position.on_earth(values["x_m"], values["y_m"])
        assert ring[:4].mean(axis=0) == pytest.approx(middle, abs=1e-9)


def test_a_figure_can_be_drawn_in_each_extreme(found):
    for count in (found.tried, np.zeros_like(found.found)):
        assert hiding_figure(replace(found, found=count)).axes


def test_report_shows_the_map_of_its_survey_only(survey, written, tmp_path, refusals):
    report = tmp_path / "report.html"
    given = ["report", survey, "--permittivity", "5", "-o", str(report), "--hiding"]
    assert main([*given, str(written / "a.json")]) == DONE
    text = report.read_text(encoding="utf-8")
    assert "Where could a mine hide?" in text and "holds for this target only" in text
    values = json.loads((written / "a.json").read_text(encoding="utf-8"))
    other = tmp_path / "other.json"
    other.write_text(json.dumps({**values, "survey_id": "another"}))
    assert main([*given, str(other), "--overwrite"]) == REFUSED
    assert main([*given, str(written / "a.gpkg"), "--overwrite"]) == REFUSED
    assert refusals == [faults.OPTION.code, faults.FILE_DAMAGED.code]


def test_wrong_files_and_endings_are_refused(found, tmp_path):
    with pytest.raises(ExportError):
        write_hiding(found, tmp_path / "a.txt")
    for content in (b"", b"{}", b"\xff\xfe", b"[1]"):
        path = tmp_path / "b.json"
        path.write_bytes(content)
        with pytest.raises(UnreadableFileError):
            read_hiding(path)


@pytest.mark.parametrize(
    "wrong",
    [
        ["--target", "tank"],
        ["--target-depths", "90", "30"],
        ["--rounds", "0"],
        ["--needed", "nan"],
        ["--step", "background:method=mean", "--loss-tangent", "2"],
        ["-o", "map.txt"],
    ],
)
def test_wrong_arguments_are_refused_before_any_work(survey, wrong, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["hiding", survey, *wrong]) == REFUSED
    assert not list(tmp_path.iterdir())
