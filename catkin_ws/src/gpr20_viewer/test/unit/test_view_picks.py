"""Picks of the viewer: undo, the file beside the survey, export."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fault_kit import raises_fault
from run_seed import draws
from survey_kit import make_survey

from gpr20_analysis import cell_text
from gpr20_analysis.faults import OUTPUT
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_viewer import faults
from gpr20_viewer.identity import SurveyIdentity
from gpr20_viewer.picks import Pick, PickEditor, PickRefusedError
from gpr20_viewer.picks_file import CSV, JSON, PicksFile, PicksFileError, picks_path

IDENTITY = SurveyIdentity("0f8fad5b-d9cb-469f-a165-70867728950e", "a" * 64, True)


def pick(x_m=0.1, **changes):
    values = {"y_m": 0.2, "depth_m": 0.05, "polarization_deg": 0.0, "permittivity": 4.0}
    values.update(permittivity_source="slider", level_db=-3.0, note="", author="Ana Peña")
    return Pick("", x_m, time="2026-11-22T12:00:00Z", **{**values, **changes})


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
        final = editor.picks
        for expected in reversed(states[:-1]):
            editor.undo()
            assert editor.picks == expected, seed
        editor.undo()
        assert editor.picks == () and not editor.can_undo, seed
        for _ in states:
            editor.redo()
        assert editor.picks == final and not editor.can_redo, seed


def test_a_bounced_click_makes_one_pick_and_no_name_is_used_again():
    draw = np.random.default_rng(1)
    for _ in range(draws(5)):
        editor = PickEditor()
        editor.add(pick(0.1))
        x_m, y_m = 0.1 + draw.uniform(-0.002, 0.002), 0.2 + draw.uniform(-0.002, 0.002)
        with raises_fault(faults.PICK, "P1"):
            editor.add(pick(x_m, y_m=y_m))
        assert len(editor.picks) == 1 and editor.next_number == 2
        editor.add(pick(0.1, polarization_deg=90.0))
        editor.remove("P1")
        assert editor.add(pick(0.1)).id == "P3"


def test_a_pick_that_is_not_possible_is_refused():
    for change in ({"x_m": np.nan}, {"depth_m": -0.1}, {"permittivity": 0.5}, {"note": "x" * 2001}):
        with pytest.raises(PickRefusedError):
            replace(pick(), **change)


def test_picks_come_back_as_they_were_stored(tmp_path):
    for seed in range(draws(3)):
        draw = np.random.default_rng(seed)
        path = tmp_path / f"{seed}.picks.json"
        editor = PickEditor()
        for number in range(draw.integers(1, 6)):
            note = "".join(map(chr, draw.integers(32, 0x2FFF, 20)))
            level_db = None if draw.random() < 0.3 else float(draw.normal())
            editor.add(pick(float(draw.uniform()) + number, note=note, level_db=level_db))
        editor.remove(editor.picks[-1].id)
        PicksFile(path, IDENTITY).save(editor)
        file = PicksFile(path, IDENTITY)
        loaded, notes = file.load()
        assert loaded.picks == editor.picks and loaded.next_number == editor.next_number, seed
        assert notes == []
        loaded.add(pick(99.0))
        file.save(loaded)
        stored = json.loads(path.read_text(encoding="utf-8"))
        assert stored["simulated"] is True and "no clearance" in stored["notice"]


def test_picks_of_another_survey_are_refused_and_kept(tmp_path):
    path = tmp_path / "survey.picks.json"
    editor = PickEditor()
    editor.add(pick())
    PicksFile(path, IDENTITY).save(editor)
    before = path.read_bytes()
    nameless = replace(IDENTITY, survey_id="")
    for other in (replace(IDENTITY, survey_id="another"), nameless):
        with raises_fault(faults.PICKS_FILE):
            PicksFile(path, other).load()
    assert path.read_bytes() == before
    continued = PicksFile(path, replace(IDENTITY, sha256="b" * 64))
    assert "other data" in str(continued.load()[1][0])
    # Data without an id are told apart by their numbers.
    path.unlink()
    PicksFile(path, nameless).save(PickEditor())
    PicksFile(path, nameless).load()
    with raises_fault(faults.PICKS_FILE):
        PicksFile(path, replace(nameless, sha256="b" * 64)).load()


def test_a_file_that_another_program_changed_is_not_overwritten(tmp_path):
    path = tmp_path / "survey.picks.json"
    first, second = PicksFile(path, IDENTITY), PicksFile(path, IDENTITY)
    mine, _ = first.load()
    theirs, _ = second.load()
    mine.add(pick())
    first.save(mine)
    with raises_fault(faults.PICKS_CHANGED):
        second.save(theirs)
    assert PicksFile(path, IDENTITY).load()[0].picks == mine.picks


def test_a_damaged_file_is_refused_and_left_alone(tmp_path):
    path = tmp_path / "survey.picks.json"
    editor = PickEditor()
    editor.add(pick())
    PicksFile(path, IDENTITY).save(editor)
    whole = path.read_bytes()
    draw = np.random.default_rng(1)
    for number in range(draws(50)):
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


WRITER = """
import sys
sys.path[:0] = {paths}
from pathlib import Path
from test_view_picks import IDENTITY, pick
from gpr20_viewer.picks import PickEditor
from gpr20_viewer.picks_file import PicksFile
file, editor = PicksFile(Path({path}), IDENTITY), PickEditor()
for number in range(100000):
    editor.add(pick(float(number)))
    file.save(editor)
    print(number + 1, flush=True)
"""


def test_a_killed_save_leaves_a_whole_file_with_every_stored_pick(tmp_path):
    path = tmp_path / "survey.picks.json"
    paths = [str(Path(__file__).parent), *sys.path]
    program = WRITER.format(paths=paths, path=repr(str(path)))
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as writer:
        lines = [
            writer.stdout.readline() for _ in range(int(np.random.default_rng(4).integers(3, 40)))
        ]
        writer.kill()
        stored = max(map(int, [*lines, *writer.stdout]))
    picks = PicksFile(path, IDENTITY).load()[0].picks
    assert [one.x_m for one in picks] == [float(one) for one in range(len(picks))]
    assert stored <= len(picks) <= stored + 1


def test_picks_of_a_sealed_survey_are_beside_its_folder(tmp_path, monkeypatch):
    folder = make_survey(tmp_path, 18, "finished")
    beside = folder.with_name(f"{folder.name}.picks.json")
    inputs = [folder, folder / "survey.bag", folder / "survey.mcap", folder / "traces"]
    assert [picks_path(one) for one in inputs] == [beside] * 4
    copied = tmp_path / "survey.bag"
    assert picks_path(copied) == tmp_path / "survey.bag.picks.json"
    monkeypatch.chdir(folder)
    assert picks_path(Path(".")) == beside
    link = tmp_path / "link"
    link.symlink_to(folder)
    assert picks_path(link) == beside
    identity = SurveyIdentity.of(load_survey(folder))
    assert identity == SurveyIdentity.of(load_survey(folder / "survey.mcap"))
    editor = PickEditor()
    editor.add(pick())
    PicksFile(beside, identity).save(editor)
    for inside in (folder / "picks.json", folder / "traces" / "picks.json", link / "a.json"):
        with raises_fault(faults.PICKS_FILE):
            PicksFile(inside, identity)
    with pytest.raises(PicksFileError):
        PicksFile(beside, identity).export(editor, folder / "picks.csv")
    assert verify_survey(folder).faults == []


def test_exported_picks_say_what_they_are(tmp_path):
    editor = PickEditor()
    editor.add(pick(note='=1+1, "quoted"\nsecond line'))
    editor.add(pick(0.3, level_db=None))
    file = PicksFile(tmp_path / "survey.picks.json", IDENTITY)
    for suffix in (CSV, JSON):
        file.export(editor, tmp_path / f"out{suffix}")
    with (tmp_path / "out.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["x_m"]) for row in rows] == [0.1, 0.3]
    assert rows[0]["note"].startswith("'=")
    assert cell_text(rows[0]["note"]) == editor.picks[0].note and rows[1]["level_db"] == ""
    record = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert record["picks"][0]["author"] == "Ana Peña"
    for one in (*rows, record):
        assert one["simulated"] == "SIMULATED" and "no clearance" in one["notice"]
        assert one["survey_id"] == IDENTITY.survey_id
    with raises_fault(OUTPUT):
        file.export(editor, tmp_path / "out.xls")
    with pytest.raises(PicksFileError):
        file.export(editor, file.path)
