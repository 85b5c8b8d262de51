"""Files of candidates, opened by readers that are not ours."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pyogrio
import pytest
from echoes_kit import image_of
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from noise_kit import survey

from gpr20_analysis.candidates.files import write_candidates
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED, AreaPosition

PEAKS = [(0, 0.15, 0.15, 0.15, 40.0), (1, 0.15, 0.15, 0.15, 35.0), (0, 0.05, 0.24, 0.2, 38.0)]
POSITION = {"latitude_deg": 4.60283, "longitude_deg": -74.06514, "heading_deg": 30.0}
ENDINGS = (".csv", ".json", ".geojson")


def found(**attributes):
    image = image_of(PEAKS, weak=0, simulated=1, survey_id="s-1", **attributes)
    listed = find_candidates(image)
    return replace(listed, omitted=7, notes=(Message("two samples were left out"),))


@pytest.mark.parametrize("ending", ENDINGS)
def test_every_file_says_what_the_list_is_and_has_its_checksum(tmp_path, ending):
    path = tmp_path / f"list{ending}"
    write_candidates(found(**POSITION), str(path))
    text = path.read_text(encoding="utf-8")
    for one in (str(NO_CLEARANCE), str(SIMULATED), "s-1", "phase-shift", "two samples were left"):
        assert one in text
    for name in ("permittivity_lowest", "permittivity_highest", "false_alarms_per_m2", "least_db"):
        assert name in text
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert (tmp_path / f"list{ending}.sha256").read_text() == f"{digest}  list{ending}\n"
    assert sorted(one.name for one in tmp_path.iterdir()) == [path.name, f"{path.name}.sha256"]


def test_gdal_reads_points_on_the_earth(tmp_path):
    listed = found(**POSITION)
    path = tmp_path / "list.geojson"
    write_candidates(listed, path)
    meta, _, geometry, fields = pyogrio.raw.read(path, layer=pyogrio.list_layers(path)[0][0])
    assert meta["crs"] == "EPSG:4326" and meta["geometry_type"] == "Point"
    assert list(dict(zip(meta["fields"], fields))["id"]) == [one.id for one in listed.candidates]
    for wkb, one in zip(geometry, listed.candidates):
        there = listed.position.on_earth(one.x_m, one.y_m)
        assert np.frombuffer(wkb[-16:]) == pytest.approx(there, abs=1e-8)


def test_without_a_place_geojson_is_refused(tmp_path):
    listed = found(latitude_deg=4.6, longitude_deg=-74.0)
    assert listed.position is None
    with raises_fault(NOT_ALLOWED):
        write_candidates(listed, tmp_path / "list.geojson")
    assert not (tmp_path / "list.geojson").exists()


@given(
    st.floats(-80.0, 80.0), st.floats(-180.0, 180.0), st.floats(0.0, 360.0), st.floats(-5.0, 5.0),
    st.floats(-5.0, 5.0),
)  # fmt: skip
def test_places_on_the_earth_are_as_far_and_in_the_direction_they_should_be(
    latitude, longitude, heading, x_m, y_m
):
    there = AreaPosition(latitude, longitude, heading).on_earth(x_m, y_m)
    offset = cartesian(*there) - cartesian(longitude, latitude)
    lam, phi = np.radians([longitude, latitude])
    east = np.array([-np.sin(lam), np.cos(lam), 0.0])
    north = np.array([-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)])
    turn = np.radians(heading)
    along_y = east * np.sin(turn) + north * np.cos(turn)
    along_x = east * np.cos(turn) - north * np.sin(turn)
    assert [offset @ along_x, offset @ along_y] == pytest.approx([x_m, y_m], abs=1e-3)


def cartesian(longitude_deg, latitude_deg):
    """Return the place on the WGS 84 ellipsoid relative to the center of the earth [m]."""
    lam, phi = np.radians([longitude_deg, latitude_deg])
    flat = 1.0 / 298.257223563
    second = flat * (2.0 - flat)
    radius = 6378137.0 / np.sqrt(1.0 - second * np.sin(phi) ** 2)
    return radius * np.array(
        [np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), (1.0 - second) * np.sin(phi)]
    )


def test_the_command_prints_and_writes_and_replaces_nothing_unasked(tmp_path, capsys):
    data = survey(np.random.default_rng(1), 1.0, [(0.11, 0.12, 0.08)])
    source, listed = tmp_path / "survey.nc", tmp_path / "list.csv"
    write_dataset(data, source)
    command = ["candidates", str(source), "--permittivity", "4", "-o", str(listed)]
    assert main(command) == DONE
    printed = capsys.readouterr().out
    assert str(NO_CLEARANCE) in printed and "C01" in printed
    before = listed.read_bytes()
    assert main(command) == REFUSED
    assert "--overwrite" in capsys.readouterr().err and listed.read_bytes() == before
    assert main([*command, "--overwrite", "--json", "--false-alarms", "0.5"]) == DONE
    assert json.loads(capsys.readouterr().out)["false_alarms_per_m2"] == pytest.approx(0.5)
    assert main([*command[:-2], "--false-alarms", "0"]) == REFUSED
