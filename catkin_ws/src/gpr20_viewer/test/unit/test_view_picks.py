"""Picks of the viewer: undo, the file beside the survey, export."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from run_seed import draws
from survey_kit import make_survey

from gpr20_analysis import cell_text
from gpr20_analysis.errors import PICKS_CHANGED
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_common.faults import NOT_ALLOWED
from gpr20_viewer.picks import Pick, PickEditor, PickRefusedError
from gpr20_viewer.picks_file import PicksFile, PicksFileError, SurveyIdentity, picks_path

IDENTITY = SurveyIdentity("0f8fad5b-d9cb-469f-a165-70867728950e", "a" * 64, True)


def pick(x_m=0.1, **changes):
    values = {"y_m": 0.2, "depth_m": 0.05, "polarization_deg": 0.0, "permittivity": 4.0}
    values.update(permittivity_source="slider", level_db=-3.0, note="", author="Ana Peña")
    return Pick("", x_m, time="2026-11-22T12:00:00Z", **{**values, **changes})


@pytest.fixture
def editor():
    editor = PickEditor()
    editor.add(pick())
    return editor


@pytest.fixture
def path(tmp_path, editor):
    path = tmp_path / "survey.picks.json"
    PicksFile(path, IDENTITY).save(editor)
    return path


def test_undo_goes_back_through_every_state():
    for seed in range(draws(8)):
        draw = np.random.default_rng(seed)
        editor, states = PickEditor(), [()]
        for number in range(25):
            choice = draw.integers(3)
            if choice == 0 or not editor.picks:
                editor.add(pick(0.1 + 0.01 * number))
            elif choice == 1:
                editor.remove(draw.choice([one.id for one in editor.picks]))
            else:
                editor.set_note(draw.choice([one.id for one in editor.picks]), f"note {number}")
            states.append(editor.picks)
        for expected in reversed(states[:-1]):
            editor.undo()
            assert editor.picks == expected, seed
        editor.undo()
        assert editor.picks == (), seed


def test_a_bounced_click_makes_one_pick_and_no_name_is_used_again(editor):
    with raises_fault(NOT_ALLOWED, "P1"):
        editor.add(pick(0.102, y_m=0.198))
    assert len(editor.picks) == 1
    editor.add(pick(polarization_deg=90.0))
    editor.remove("P1")
    assert editor.add(pick()).id == "P3"


def test_a_pick_that_is_not_possible_is_refused():
    for change in ({"x_m": np.nan}, {"depth_m": -0.1}, {"permittivity": 0.5}):
        with pytest.raises(PickRefusedError):
            replace(pick(), **change)


def test_picks_come_back_as_they_were_stored(path, editor):
    draw = np.random.default_rng(1)
    for number in range(1, 5):
        note = "".join(map(chr, draw.integers(32, 0x2FFF, 20)))
        editor.add(pick(float(number), note=note, level_db=(None, -3.5)[number % 2]))
    editor.remove(editor.picks[-1].id)
    file = PicksFile(path, IDENTITY)
    file.load()
    file.save(editor)
    loaded, notes = PicksFile(path, IDENTITY).load()
    assert loaded.picks == editor.picks and loaded.next_number == editor.next_number
    assert notes == []
    record = json.loads(path.read_text(encoding="utf-8"))
    assert record["simulated"] is True and "no clearance" in record["notice"]


def test_picks_of_another_survey_are_refused_and_kept(path):
    before = path.read_bytes()
    nameless = replace(IDENTITY, survey_id="")
    for other in (replace(IDENTITY, survey_id="another"), nameless):
        with raises_fault(NOT_ALLOWED):
            PicksFile(path, other).load()
    assert path.read_bytes() == before
    continued = PicksFile(path, replace(IDENTITY, survey_sha256="b" * 64))
    assert "other data" in str(continued.load()[1][0])
    # Data without an id are told apart by their numbers.
    path.unlink()
    PicksFile(path, nameless).save(PickEditor())
    PicksFile(path, nameless).load()
    with raises_fault(NOT_ALLOWED):
        PicksFile(path, replace(nameless, survey_sha256="b" * 64)).load()


def test_a_file_that_another_program_changed_is_not_overwritten(path):
    first, second = PicksFile(path, IDENTITY), PicksFile(path, IDENTITY)
    mine, _ = first.load()
    theirs, _ = second.load()
    mine.add(pick(0.3))
    first.save(mine)
    with raises_fault(PICKS_CHANGED):
        second.save(theirs)
    assert PicksFile(path, IDENTITY).load()[0].picks == mine.picks


def test_a_damaged_file_is_refused_and_left_alone(path):
    whole, draw = path.read_bytes(), np.random.default_rng(1)
    for number in range(draws(25)):
        data = bytearray(whole)
        if number % 2:
            del data[draw.integers(1, len(data) - 2) :]
        else:
            data[draw.integers(len(data) - 2)] ^= 1 << draw.integers(7)
        path.write_bytes(data)
        try:
            loaded, _ = PicksFile(path, IDENTITY).load()
        except PicksFileError:
            assert path.read_bytes() == data
        else:
            assert all(isinstance(one, Pick) for one in loaded.picks)


def test_picks_of_a_sealed_survey_are_beside_its_folder(tmp_path, editor):
    folder = make_survey(tmp_path, 18, "finished")
    beside = folder.with_name(f"{folder.name}.picks.json")
    link = tmp_path / "link"
    link.symlink_to(folder)
    for one in (folder, link, *(folder / name for name in ("survey.bag", "survey.mcap", "traces"))):
        assert picks_path(one) == beside
    assert picks_path(tmp_path / "survey.bag") == tmp_path / "survey.bag.picks.json"
    identity = SurveyIdentity.of(load_survey(folder))
    assert identity == SurveyIdentity.of(load_survey(folder / "survey.mcap"))
    PicksFile(beside, identity).save(editor)
    for inside in (folder / "picks.json", folder / "traces" / "picks.json", link / "a.json"):
        with raises_fault(NOT_ALLOWED):
            PicksFile(inside, identity)
    with pytest.raises(PicksFileError):
        PicksFile(beside, identity).export(editor, folder / "picks.csv")
    assert verify_survey(folder).faults == []


def test_exported_picks_say_what_they_are(tmp_path, path, editor):
    editor.add(pick(0.3, note='=1+1, "quoted"\nsecond line', level_db=None))
    PicksFile(path, IDENTITY).export(editor, tmp_path / "out.csv")
    with (tmp_path / "out.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["x_m"]) for row in rows] == [0.1, 0.3]
    assert rows[1]["note"].startswith("'=")
    assert cell_text(rows[1]["note"]) == editor.picks[1].note and rows[1]["level_db"] == ""
    for row in rows:
        assert row["simulated"] == "SIMULATED" and "no clearance" in row["notice"]
        assert (row["survey_id"], row["author"]) == (IDENTITY.survey_id, "Ana Peña")
    with raises_fault(NOT_ALLOWED):
        PicksFile(path, IDENTITY).export(editor, path)
