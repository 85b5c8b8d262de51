"""gpr20 found: what was found is stored with the survey, corrected, verified and scored."""

from __future__ import annotations

import json
import os

import pytest
from candidate_examples import candidate, candidate_list
from survey_kit import POINTS, SURVEY, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.verify import main as gpr20_verify
from gpr20_survey.folder.annotating import Fact, add_to_survey
from gpr20_survey.folder.found_records import read_found
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.candidate_json import json_text
from gpr20_survey.results.found import What, present

PHOTO = b"\xff\xd8\xff a photograph"


@pytest.fixture
def folder(tmp_path):
    return make_survey(tmp_path, len(POINTS), "finished")


@pytest.fixture
def listed(tmp_path):
    places = [candidate(1, 150.0, 90.0), candidate(2, 300.0, 90.0), candidate(3, 450.0, 90.0)]
    path = tmp_path / "list.json"
    path.write_text(json_text(candidate_list(places, survey_id=SURVEY)), encoding="utf-8")
    return path


def note(folder, listed, name, what, *options):
    given = ("--list", str(listed), "--what", what, "--who", "Ana", *options)
    return main(["found", str(folder), name, *given])


def test_a_record_has_place_depth_list_who_and_photograph(folder, listed, tmp_path, capsys):
    photo = tmp_path / "IMG 1.JPG"
    photo.write_bytes(PHOTO)
    options = ("--depth-mm", "40", "--photo", str(photo), "--notes", "PMN")
    assert note(folder, listed, "C02", "device", *options) == 0
    (one,) = read_found(folder)
    assert (one.what, one.x_mm, one.y_mm, one.depth_mm) == (What.DEVICE, 300.0, 90.0, 40.0)
    assert (one.candidate, one.who, one.notes) == ("C02", "Ana", "PMN")
    assert len(one.list_sha256) == 64
    assert (folder / "photos" / one.photo).read_bytes() == PHOTO
    assert gpr20_verify([str(folder)]) == 0
    assert "C02" in capsys.readouterr().out


def test_a_correction_is_a_new_record_and_the_former_one_stays(folder, listed, capsys):
    assert note(folder, listed, "C01", "device") == note(folder, listed, "C01", "scrap") == 0
    assert note(folder, listed, "C03", "device") == 0
    records = read_found(folder)
    assert [one.what for one in records] == [What.DEVICE, What.SCRAP, What.DEVICE]
    assert [one.candidate for one in present(records)] == ["C01", "C03"]
    capsys.readouterr()
    assert main(["found", str(folder)]) == 0
    assert [line.split()[:4] for line in capsys.readouterr().out.splitlines()] == [
        ["C01", "150", "90", "scrap"], ["C03", "450", "90", "device"],
    ]  # fmt: skip


@pytest.mark.parametrize("damage", ["changed", "removed", "replaced by a link"])
def test_verify_finds_a_photograph_that_is_not_the_one_of_the_log(
    folder, listed, tmp_path, damage, capsys
):
    photo = tmp_path / "a.png"
    photo.write_bytes(PHOTO)
    assert note(folder, listed, "C01", "scrap", "--photo", str(photo)) == 0
    stored = folder / "photos" / read_found(folder)[0].photo
    if damage == "changed":
        stored.write_bytes(PHOTO + b".")
    else:
        stored.unlink()
    if damage == "replaced by a link":
        stored.symlink_to(photo)
    capsys.readouterr()
    assert gpr20_verify([str(folder)]) == 2
    assert f"photos/{stored.name}" in capsys.readouterr().out


def test_a_folder_of_photographs_that_leads_elsewhere_is_refused(folder, listed, tmp_path):
    elsewhere, photo = tmp_path / "elsewhere", tmp_path / "a.png"
    elsewhere.mkdir()
    photo.write_bytes(PHOTO)
    (folder / "photos").symlink_to(elsewhere)
    assert note(folder, listed, "C01", "scrap", "--photo", str(photo)) == 3
    assert list(elsewhere.iterdir()) == [] and gpr20_verify([str(folder)]) == 2


def test_a_photograph_of_an_interrupted_command_damages_nothing(folder, listed, tmp_path):
    (folder / "photos").mkdir()
    (folder / "photos" / f"{'0' * 64}.jpg").write_bytes(PHOTO)
    assert gpr20_verify([str(folder)]) == 0
    assert note(folder, listed, "C01", "nothing") == 0
    assert gpr20_verify([str(folder)]) == 0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("C09", "--list", "{list}", "--what", "scrap", "--who", "A"), "C01, C02, C03"),
        (("C01", "--what", "scrap", "--who", "A"), "--list"),
        (("--what", "scrap", "--who", "A"), "candidate"),
        (("C01", "--list", "{list}", "--what", "scrap"), "who"),
        (("C01", "--list", "{list}"), "--what"),
        (("C01", "--list", "{list}", "--what", "scrap", "--who", "A\nB"), "who"),
        (("C01", "--list", "{list}", "--what", "scrap", "--who", "A", "--depth-mm", "-1"), "10000"),
        (("C01", "--list", "{list}", "--what", "scrap", "--who", "A", "--photo", "{list}"), "jpg"),
        (("C01", "--list", "{folder}/survey.json", "--what", "scrap", "--who", "A"), "candidates"),
    ],
)
def test_what_is_not_complete_is_refused_and_nothing_is_stored(
    folder, listed, options, said, capsys
):
    before = sorted(os.walk(folder))
    given = [one.format(list=listed, folder=folder) for one in options]
    assert main(["found", str(folder), *given]) == 3
    assert said in capsys.readouterr().err
    assert sorted(os.walk(folder)) == before and read_found(folder) == []


def test_a_record_of_a_later_version_is_left_out_and_a_damaged_one_is_a_fault(
    folder, listed, capsys
):
    assert note(folder, listed, "C01", "scrap") == 0
    (one,) = read_found(folder)
    for values, status in (({"format": "gpr20-found/9"}, 0), ({**one.values(), "who": ""}, 2)):
        fact = Fact(Kind.FOUND, values)
        add_to_survey(folder, lambda _description, fact=fact: fact, one.time)
        assert gpr20_verify([str(folder)]) == status
        if status == 0:
            assert read_found(folder) == [one]
    assert main(["found", str(folder)]) == 3
    assert "not as it should be" in capsys.readouterr().err


def test_a_list_of_another_survey_is_refused(folder, tmp_path):
    other = tmp_path / "other.json"
    other.write_text(json_text(candidate_list([candidate(1)])), encoding="utf-8")
    assert note(folder, other, "C01", "scrap") == 3
    score = ["trial", "score", str(other), "--found", str(folder), "--halo", "0.05"]
    assert main(score) == 3 and read_found(folder) == []


def test_a_survey_that_has_not_ended_is_refused(tmp_path, listed, refusals):
    assert note(make_survey(tmp_path, 3, None), listed, "C01", "scrap") == 3
    assert refusals == [faults.SURVEY_RUNS.code]


def test_found_records_score_candidates_and_say_that_pd_is_not_known(
    folder, listed, tmp_path, capsys
):
    # A former list had a candidate 20 mm from C03.
    former = tmp_path / "former.json"
    places = [candidate(1, 430.0, 90.0), candidate(2, 900.0, 90.0)]
    former.write_text(json_text(candidate_list(places, survey_id=SURVEY)), encoding="utf-8")
    assert note(folder, listed, "C01", "nothing") == note(folder, former, "C01", "device") == 0
    assert note(folder, former, "C02", "device") == 0
    report = tmp_path / "report.json"
    score = ["trial", "score", str(listed), "--found", str(folder), "--halo", "0.05"]
    assert main([*score, "-o", str(report)]) == 0
    values = json.loads(report.read_text())
    (group,), (lane,) = values["groups"], values["lanes"]
    assert (group["targets"], group["found"], group["alarms"]) == (2, 1, 1)
    assert group["detection"] is None and group["alarms_per_m2"] == 1 / group["area_m2"]
    assert [one["id"] for one in lane["found"].values() if one] == ["C03"]
    assert [one["id"] for one in lane["outside"]] == ["C02"]
    printed = capsys.readouterr().out
    assert "PD cannot be known" in printed and "SIMULATED" in printed
    assert main([*score, "-o", str(tmp_path / "report.html")]) == 0
    assert "PD cannot be known" in (tmp_path / "report.html").read_text()
    assert main(score[:-2]) == main([*score, "--truth", "x.csv"]) == 3
