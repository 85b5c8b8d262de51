"""What people noted of a survey: repaired from its other form, or named as unconfirmed for ever.

GPR20_DAMAGES sets how many surveys are damaged, GPR20_SEED repeats those of a run.
"""

from __future__ import annotations

import csv
import json
import os
import random
import re
import shutil
import string
from pathlib import Path

import pytest
from run_seed import SEED
from survey_kit import POINTS, SURVEY, add_marker, make_survey, remove_marker

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.faults import UNCONFIRMED
from gpr20_survey.folder import manifest
from gpr20_survey.folder.annotating import add_to_survey, annotate
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.markers import Marker, markers_of

DAMAGES = int(os.environ.get("GPR20_DAMAGES", "40"))
NOW = "2026-11-21T05:10:00.000000Z"
IDS = [f"7c9e6679-7425-40de-944b-e07fc1f90a{number:02d}" for number in range(5)]
MARKERS = [
    Marker(one, 110.0 + number, 20.0, 80.0, f"marker {number}") for number, one in enumerate(IDS)
]
DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3


def note_during(processing):
    """Add two markers, an annotation and a report to the open survey."""
    for marker in MARKERS[:2]:
        processing.add_marker("", marker)
    processing.annotate("", Annotation(operator="Ana"))
    processing.report(SURVEY, json.dumps({"complete": True}))


@pytest.fixture(scope="module")
def noted(tmp_path_factory):
    folder = make_survey(
        tmp_path_factory.mktemp("noted"), len(POINTS), "finished", at_end=note_during
    )
    for marker in MARKERS[2:4]:
        add_marker(folder, marker, NOW)
    remove_marker(folder, MARKERS[0], "Luis", NOW)
    add_to_survey(folder, annotate(Annotation(operator="Ana", site="El Carmen")), NOW)
    add_marker(folder, MARKERS[4], NOW)
    assert verify_survey(folder).status == DONE
    return folder


@pytest.fixture
def copy(noted, tmp_path):
    return Path(shutil.copytree(str(noted), str(tmp_path / noted.name)))


def flip(content, chance):
    changed = bytearray(content)
    changed[chance.randrange(len(changed))] ^= chance.randrange(1, 256)
    return bytes(changed)


def retype(content, chance):
    """Change a character of a text to another letter or digit, so that it may stay readable."""
    changed = bytearray(content)
    places = [place for place, one in enumerate(content) if bytes([one]).isalnum()]
    changed[chance.choice(places)] = ord(chance.choice(string.ascii_letters + string.digits))
    return bytes(changed)


def spoil(path, chance):
    """Damage a file in one of several ways; a manifest may be lost as well."""
    content = path.read_bytes()
    kind = chance.choice(["flip", "flips", "retyped", "cut", "lost", "empty", "noise"])
    if kind == "lost":
        path.unlink()
    elif kind == "cut":
        path.write_bytes(content[: chance.randrange(len(content))])
    elif kind in ("empty", "noise"):
        path.write_bytes(b"" if kind == "empty" else chance.getrandbits(800).to_bytes(100, "big"))
    else:
        change = retype if kind == "retyped" else flip
        for _ in range(5 if kind == "flips" else 1):
            content = change(content, chance)
        path.write_bytes(content)
    return f"{path.name} {kind}"


def damaged(noted, place, number, names):
    """Return a copy of the survey in which these files are damaged, and what was done."""
    chance = random.Random(f"{SEED} {number}")
    folder = Path(shutil.copytree(str(noted), str(place / str(number) / noted.name)))
    done = [spoil(folder / name, chance) for name in chance.choice(names)]
    return folder, f"{number}: {done}, GPR20_SEED={SEED}"


ONE_FORM = (
    *(("survey.json",), ("log.jsonl",), ("manifest.json",)),
    *(("survey.json", "manifest.json"), ("log.jsonl", "manifest.json")),
)


def test_damage_of_one_form_of_the_log_and_of_the_manifest_loses_nothing(noted, tmp_path):
    wanted = read_description(noted)
    for number in range(DAMAGES):
        folder, where = damaged(noted, tmp_path, number, ONE_FORM)
        assert read_description(folder) == wanted, where
        assert main(["repair", str(folder)]) == DONE, where
        assert verify_survey(folder).status == DONE, where
        assert read_description(folder) == wanted, where
        for name in ("survey.json", "log.jsonl"):
            assert (folder / name).read_bytes() == (noted / name).read_bytes(), where
        shutil.rmtree(str(folder))


@pytest.mark.parametrize("name", ["survey_id", "started", "parameters", "outcome", "fault_code"])
def test_a_changed_key_of_survey_json_is_repaired_without_a_manifest(noted, copy, name):
    path = copy / "survey.json"
    (copy / "manifest.json").unlink()
    path.write_text(path.read_text("ascii").replace(f'"{name}"', f'"{name[:-1]}0"', 1))
    assert main(["repair", str(copy)]) == DONE
    assert path.read_bytes() == (noted / path.name).read_bytes()


BOTH_FORMS = (("survey.json", "log.jsonl"), ("survey.json", "log.jsonl", "manifest.json"))


def test_damage_of_both_forms_of_the_log_never_changes_what_is_left(noted, tmp_path):
    wanted = {one.marker_id: one for one in markers_of(read_description(noted))}
    for number in range(DAMAGES):
        folder, where = damaged(noted, tmp_path, number, BOTH_FORMS)
        before = {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}
        status = main(["repair", str(folder)])
        if status in (DAMAGED, REFUSED):
            after = {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}
            assert after == before, where
            assert verify_survey(folder).status == DAMAGED, where
        else:
            description = read_description(folder)
            unconfirmed = verify_survey(folder).unconfirmed
            assert bool(unconfirmed) == (status == NOT_COMPLETE), where
            lost = wanted.keys() - {one.marker_id for one in markers_of(description)}
            assert not lost or unconfirmed, where
            for one in markers_of(description):
                former = wanted[one.marker_id]
                same = one == former or (unconfirmed and one.same_request(former))
                assert same, where
        shutil.rmtree(str(folder))


def number_of(folder, kind, place):
    records = recover(folder).found.records
    return [one.number for one in records if one.kind == kind.value][place]


def change_in_both(folder, number, former, changed):
    """Change the same digits of a record in log.jsonl and in survey.json."""
    path = folder / "log.jsonl"
    lines = path.read_bytes().split(b"\n")
    assert former in lines[number]
    lines[number] = lines[number].replace(former, changed, 1)
    path.write_bytes(b"\n".join(lines))
    path = folder / "survey.json"
    values = json.loads(path.read_text("ascii"))
    record = json.dumps(values["log"][number])
    values["log"][number] = json.loads(re.sub(rb" (?=[0-9])", b"", record.encode()).replace(
        former, changed, 1))  # fmt: skip
    path.write_text(json.dumps(values, indent=2) + "\n", "ascii")


@pytest.mark.parametrize("place", [2, -1])
def test_a_record_that_is_damaged_in_both_forms_is_unconfirmed_for_ever(copy, capsys, place):
    number = number_of(copy, Kind.MARKER, place)
    lost = next(
        one for one in recover(copy).found.records if one.number == number
    ).values["marker_id"]  # fmt: skip
    change_in_both(copy, number, b'"y_mm":20', b'"y_mm":90')
    found = verify_survey(copy)
    assert found.status == DAMAGED
    assert main(["repair", str(copy)]) == NOT_COMPLETE
    kept = read_description(copy)["unconfirmed"][f"record {number}"]["found"]
    assert len(kept) == 2 and all('"y_mm": 90' in one for one in kept)
    for _ in range(2):
        found = verify_survey(copy)
        assert (found.status, found.faults) == (NOT_COMPLETE, [])
        assert found.verdict.fault_code == UNCONFIRMED.code
        assert f"record {number}" in str(found.verdict) and "UNCONFIRMED" in str(found.verdict)
        assert manifest.read_manifest(copy).unconfirmed == (f"record {number}",)
        assert read_description(copy)["unconfirmed"][f"record {number}"]["found"] == kept
        assert lost not in [one.marker_id for one in markers_of(read_description(copy))]
        assert main(["repair", str(copy)]) == NOT_COMPLETE
    assert main(["annotate", str(copy), "--site", "here"]) == DONE
    assert verify_survey(copy).unconfirmed == (f"record {number}",)
    capsys.readouterr()
    assert main(["info", str(copy)]) == DONE
    assert f"record {number}" in capsys.readouterr().out


def test_a_record_of_the_time_of_measurement_is_found_in_the_mcap(copy):
    wanted = read_description(copy)
    number = number_of(copy, Kind.MARKER, 1)
    change_in_both(copy, number, b'"y_mm":20', b'"y_mm":90')
    assert verify_survey(copy).status == DAMAGED
    assert main(["repair", str(copy)]) == DONE
    assert read_description(copy) == wanted


def test_markers_that_nothing_vouches_for_are_marked_as_such(copy, tmp_path, capsys):
    """A survey of an earlier version, which has no log, was cut off, and has no manifest."""
    for name in ("manifest.json", "log.jsonl", "survey.mcap"):
        (copy / name).unlink()
    path = copy / "survey.json"
    values = json.loads(path.read_text("ascii"))
    del values["log"]
    path.write_text(json.dumps(values))
    survey = load_survey(copy)
    assert "markers/3" in survey.attrs["notes"][0]
    table, collection = tmp_path / "m.csv", tmp_path / "m.geojson"
    assert main(["markers", str(copy), "-o", str(table), "-o", str(collection)]) == DONE
    assert capsys.readouterr().out.count("UNCONFIRMED") == 4
    rows = list(csv.DictReader(
        line for line in table.read_text("utf-8").splitlines() if not line.startswith("#")
    ))  # fmt: skip
    assert {one["confirmed"] for one in rows} == {"False"}
    features = json.loads(collection.read_text("utf-8"))["features"]
    assert {one["properties"]["confirmed"] for one in features} == {False}
