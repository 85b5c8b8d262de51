"""What people add to a survey: annotation, markers, what was found; and where each is shown."""

import csv
import json
import os
from dataclasses import replace

import pytest
from candidate_examples import candidate, candidate_list
from storage_kit import Kit
from survey_kit import POINTS, SURVEY, describe_again, make_survey

from gpr20_analysis import survey_markers
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.read.checks import found_in
from gpr20_analysis.read.load import load_survey
from gpr20_common.faults import IN_USE
from gpr20_survey.folder import recovery
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import Fact, read_description, recover
from gpr20_survey.plan.annotation import Annotation, Wgs84Position, annotation_of
from gpr20_survey.plan.markers import Marker, What, present
from gpr20_survey.results.candidates import NO_CLEARANCE, json_text

# When the storage of the tests notes something.
NOW = "2026-09-21T14:15:00.000000+00:00"
EXAMPLE = Annotation(
    "Lucía Peña", "El Carmen", "wet\nsoil", Wgs84Position(4.60283, -74.06514), name="Carmen 3"
)
OPTIONS = ["--name", "Carmen 3", "--operator", "Lucía Peña", "--site", "El Carmen"]
OPTIONS += ["--notes", "wet\nsoil"]
POSITION = ["--position", "4.60283, -74.06514"]
MARKER = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae7", 12.5, 20.0, 80.0, 'raíz, "metal"', "Ana")
SECOND = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae8", 15.0, 10.0)
PHOTO = b"\xff\xd8\xff a photograph"


@pytest.fixture
def folder(tmp_path):
    return make_survey(tmp_path, len(POINTS), "finished")


def stored(folder):
    return annotation_of(read_description(folder))


def annotate(folder, *options):
    return main(["annotate", str(folder), *options])


def test_what_is_given_is_set_and_the_rest_stays(folder, capsys):
    for options, wanted in (
        ((*OPTIONS, *POSITION), EXAMPLE),
        (("--site", ""), replace(EXAMPLE, site="")),
        (("--heading", "37.5"), replace(EXAMPLE, site="", heading_deg=37.5)),
        (("--position", "", "--heading", ""), replace(EXAMPLE, site="", position=None)),
        (("--site", "here"), replace(EXAMPLE, site="here", position=None)),
    ):
        assert annotate(folder, *options) == 0
        assert stored(folder) == wanted, options
    assert main(["verify", str(folder)]) == 0
    capsys.readouterr()
    before = (folder / "log.jsonl").read_bytes()
    assert annotate(folder) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [line.split(maxsplit=1)[-1] for line in printed[1:3]] == ["Lucía Peña", "here"]
    assert printed[0].endswith("Carmen 3") and printed[4] == f"{'':24}soil"
    assert (folder / "log.jsonl").read_bytes() == before


def test_a_wrong_value_is_refused_and_nothing_changes(folder, capsys):
    before = (folder / "log.jsonl").read_bytes()
    for options, reasons in (
        (["--position", "91,0"], ["91 deg"]),
        (["--position", "4.6"], ["latitude and longitude"]),
        (["--position", "4.6,nan"], ["'4.6,nan'", "latitude and longitude"]),
        (["--heading", "400"], ["400 deg", "360 deg"]),
        (["--site", "a\x07"], ["U+0007 at character 2"]),
    ):
        assert annotate(folder, *options) == 3, options
        error = capsys.readouterr().err
        assert all(one in error for one in reasons), error
        assert (folder / "log.jsonl").read_bytes() == before, options


def test_info_and_exports_show_the_annotation(folder, tmp_path, capsys):
    annotate(folder, *OPTIONS, *POSITION, "--heading", "37.5")
    capsys.readouterr()
    assert main(["info", str(folder), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    names = ("survey notes", "WGS 84 position", "heading of Y")
    assert [printed[name] for name in names] == ["wet\nsoil", "4.60283, -74.06514", "37.5 deg"]
    output = tmp_path / "s.nc"
    assert main(["export", str(folder), str(output), "--format", "netcdf"]) == 0
    attributes = read_dataset(output).attrs
    names = ("survey_name", "operator", "latitude_deg", "heading_deg")
    assert [attributes[name] for name in names] == ["Carmen 3", "Lucía Peña", 4.60283, 37.5]


def test_a_damaged_annotation_or_list_of_markers_does_not_hide_the_survey(folder, capsys):
    describe_again(folder, annotation={"operator": 1}, markers=5)
    survey = load_survey(folder, accept_damaged=True)
    assert "operator" not in survey.attrs
    for said in ("left out: annotation", "left out: the markers in the log are damaged"):
        assert any(said in one for one in survey.attrs["notes"])
    assert annotate(folder) == 3


def test_a_survey_that_has_not_ended_is_refused(tmp_path, listed, refusals):
    folder = make_survey(tmp_path, 3, None)
    assert annotate(folder, *OPTIONS) == note(folder, listed, "C01", "scrap") == 3
    assert refusals == [IN_USE.code] * 2
    assert annotate(folder) == 0


@pytest.fixture
def marked(folder):
    kit = Kit(folder.parent)
    for marker in (MARKER, SECOND):
        kit.add_marker(SURVEY, marker)
    kit.remove_marker(SURVEY, SECOND.marker_id, "Luis")
    kit.processing.shut_down()
    return folder


@pytest.mark.usefixtures("blank_figures")
def test_markers_are_listed_without_removed_ones(marked, tmp_path, capsys):
    assert annotate(marked) == 0
    *_, heading, line = capsys.readouterr().out.splitlines()
    assert heading.split()[:2] == ["x", "mm"]
    assert line.split()[:3] == ["12", "20", "80"] and line.endswith('raíz, "metal"')
    found = survey_markers(load_survey(marked))
    assert [one.same_request(MARKER) for one in found.markers] == [True]
    assert main(["report", str(marked), "-o", str(tmp_path / "r.html")]) == 0
    assert "raíz, &quot;metal&quot;" in (tmp_path / "r.html").read_text("utf-8")


def test_markers_are_written_in_metres_and_in_degrees_where_the_place_is_known(marked, tmp_path):
    table, collection = tmp_path / "m.csv", tmp_path / "m.geojson"
    written = ("--markers", str(table), "--markers", str(collection))
    assert annotate(marked, *written) == 0
    assert annotate(marked, "--markers", str(tmp_path / "m.gpkg")) == 3
    (unknown,) = json.loads(collection.read_text("utf-8"))["features"]
    assert unknown["geometry"] is None and unknown["properties"]["x_m"] == 0.0125
    assert annotate(marked, *POSITION, "--heading", "0", *written, "--overwrite") == 0
    (feature,) = json.loads(collection.read_text("utf-8"))["features"]
    # One degree of latitude is 110.6 km here.
    latitude_deg = feature["geometry"]["coordinates"][1]
    assert latitude_deg - 4.60283 == pytest.approx(0.02 / 110_600, rel=0.01)
    text = table.read_text("utf-8")
    (row,) = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    assert (float(row["x_m"]), float(row["y_m"]), float(row["depth_m"])) == (0.0125, 0.02, 0.08)
    assert (row["text"], row["author"], row["time"]) == (MARKER.text, "Ana", NOW)
    assert float(row["latitude_deg"]) == pytest.approx(latitude_deg, abs=1e-8)
    assert str(NO_CLEARANCE) in text


@pytest.fixture
def listed(tmp_path):
    places = [candidate(1, 150.0, 90.0), candidate(2, 300.0, 90.0), candidate(3, 450.0, 90.0)]
    path = tmp_path / "list.json"
    path.write_text(json_text(candidate_list(places, survey_id=SURVEY)), encoding="utf-8")
    return path


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "IMG 1.JPG"
    path.write_bytes(PHOTO)
    return path


def note(folder, listed, name, what, *options):
    given = ("--list", str(listed), "--what", what, "--who", "Ana", *options)
    return annotate(folder, "--found", name, *given)


def read_found(folder):
    return found_in(recover(folder).found.records)


def test_a_record_has_place_depth_list_who_and_photograph_and_is_corrected_by_another(
    folder, listed, photo, capsys
):
    (folder / "photos").mkdir()  # a command that was interrupted left a photograph
    (folder / "photos" / f"{'0' * 64}.jpg").write_bytes(PHOTO)
    options = ("--depth-mm", "40", "--photo", str(photo), "--remark", "PMN")
    assert note(folder, listed, "C02", "device", *options) == 0
    (one,) = read_found(folder)
    assert (one.what, one.x_mm, one.y_mm, one.depth_mm) == (What.DEVICE, 300.0, 90.0, 40.0)
    assert (one.candidate, one.who, one.notes) == ("C02", "Ana", "PMN")
    assert len(one.list_sha256) == 64
    assert (folder / "photos" / one.photo).read_bytes() == PHOTO
    assert main(["verify", str(folder)]) == 0
    # A correction is a new record, and the former one stays.
    assert note(folder, listed, "C02", "scrap") == note(folder, listed, "C03", "device") == 0
    records = read_found(folder)
    assert [one.what for one in records] == [What.DEVICE, What.SCRAP, What.DEVICE]
    assert [one.candidate for one in present(records)] == ["C02", "C03"]
    capsys.readouterr()
    assert annotate(folder) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [one.split()[:1] for one in printed[-2:]] == [["C02"], ["C03"]]


@pytest.mark.usefixtures("blank_figures")
def test_the_report_says_what_people_found(folder, listed, tmp_path):
    assert note(folder, listed, "C02", "device", "--remark", "PMN") == 0
    report = tmp_path / "report.html"
    main(["report", str(folder), "-o", str(report), "--permittivity", "4"])
    (section,) = report.read_text("utf-8").split("What people found")[1:]
    assert all(one in section for one in ("C02", "device", "Ana", "PMN"))


def test_verify_finds_a_photograph_that_is_not_the_one_of_the_log(folder, listed, photo, capsys):
    assert note(folder, listed, "C01", "scrap", "--photo", str(photo)) == 0
    stored = folder / "photos" / read_found(folder)[0].photo
    for damage in (
        lambda: stored.write_bytes(PHOTO + b"."),
        stored.unlink,
        lambda: stored.symlink_to(photo),
    ):
        damage()
        capsys.readouterr()
        assert main(["verify", str(folder)]) == 2
        assert f"photos/{stored.name}" in capsys.readouterr().out


def test_a_folder_of_photographs_that_leads_elsewhere_is_refused(folder, listed, photo, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (folder / "photos").symlink_to(tmp_path / "elsewhere")
    assert note(folder, listed, "C01", "scrap", "--photo", str(photo)) == 3
    assert list((tmp_path / "elsewhere").iterdir()) == [] and main(["verify", str(folder)]) == 2


def test_what_is_not_complete_is_refused_and_nothing_is_stored(folder, listed, tmp_path, capsys):
    other = tmp_path / "other.json"
    other.write_text(json_text(candidate_list([candidate(1)])), encoding="utf-8")
    before, log = sorted(os.walk(folder)), (folder / "log.jsonl").read_bytes()
    of_list, whole = ("--list", str(listed)), ("--what", "scrap", "--who", "A")
    for options, said in (
        (("--found", "C09", *of_list, *whole), "C01, C02, C03"),
        (("--name", "X", "--found", "C09", *of_list, *whole), "C01, C02, C03"),
        (("--found", "C01", *whole), "--list"),
        (whole, "--found"),
        (("--found", "C01", *of_list, "--what", "scrap"), "with --who"),
        (("--found", "C01", *of_list), "--what"),
        (("--found", "C01", *of_list, *whole, "--depth-mm", "-1"), "10000"),
        (("--found", "C01", *of_list, *whole, "--photo", str(listed)), "end in .jpg, .jpeg"),
        (("--found", "C01", "--list", str(folder / "survey.json"), *whole), "candidates"),
        (("--found", "C01", "--list", str(other), *whole), "survey"),
    ):
        assert annotate(folder, *options) == 3, options
        assert said in capsys.readouterr().err, options
    assert sorted(os.walk(folder)) == before and (folder / "log.jsonl").read_bytes() == log


def test_a_record_of_a_later_version_is_left_out_and_a_damaged_one_is_a_fault(folder, listed):
    assert note(folder, listed, "C01", "scrap") == 0
    (one,) = read_found(folder)
    for values, status in (({"format": "gpr20-found/9"}, 0), ({**one.values(), "who": ""}, 2)):
        fact = Fact(Kind.FOUND, values)
        recovery.add_to_survey(folder, lambda _description, fact=fact: fact, one.time)
        assert main(["verify", str(folder)]) == status
        if status == 0:
            assert read_found(folder) == [one]
    assert annotate(folder) == 3
