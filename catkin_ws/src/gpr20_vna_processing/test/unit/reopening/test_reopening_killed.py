"""A storage that is killed, or whose disk fails or loses its power, at any of its calls.

While it reopens a survey, adds a fact to one that is closed, or opens a new one. A change tries
every few calls, a release each of them.
"""

from __future__ import annotations

import contextlib
import itertools
import random
import shutil
import struct

import pytest
from failing_disk import FailingDisk, Failure
from fault_kit import raises_fault
from log_examples import DONE, FILES, KILLED, NOW, add_marker, change_digit, ended_at_call
from reopening_kit import TRACES, assert_whole, messages_in_mcap, noted, resume, texts, trace_file
from run_seed import LONG, SEED
from storage_kit import Kit
from trace_examples import METADATA, SURVEY

from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import StorageFailedError
from gpr20_survey.folder.recovery import add_to_survey

STORED = 6
DATA_END = struct.pack("<BQ", 0x0F, 4)


def numbers(step):
    """Return which calls of the disk are tried, until the work is done before them."""
    chance = random.Random(SEED)
    return itertools.count(1, 1) if LONG else itertools.count(1 + chance.randrange(step), step)


def damage(folder) -> None:
    """Remove a trace's file and change a byte of the MCAP, which is rebuilt."""
    trace_file(folder, 1).unlink()
    change_byte(folder / "survey.mcap")


def change_byte(path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def reopen_and_store(data) -> None:
    kit = Kit(data)
    kit.processing.reopen_survey(SURVEY)
    kit.processing.store(TRACES[STORED])


def tear(folder) -> None:
    """Leave an MCAP as a kill in the middle of a commit leaves it."""
    path = folder / "survey.mcap"
    content = path.read_bytes()
    path.write_bytes(content[: content.rindex(DATA_END) + 3])


def damage_log(folder) -> None:
    """Change a byte of log.jsonl, and one of the MCAP, which is rebuilt."""
    for name in ("log.jsonl", "survey.mcap"):
        change_byte(folder / name)


@pytest.mark.parametrize("change", [tear, damage, damage_log])
def test_a_survey_survives_a_kill_at_any_instant_of_its_reopening(copies, change):
    for number in numbers(9):
        folder = copies("stopped")
        change(folder)
        ending = ended_at_call(number, lambda data=folder.parent: reopen_and_store(data))
        assert ending in (KILLED, DONE)
        assert resume(folder).stored_indices[:STORED] == tuple(range(STORED))
        assert_whole(folder, TRACES)
        if change is tear:
            found = [one.data for one in messages_in_mcap(folder, "/t")]
            assert found == [f"before {index}" for index in range(STORED)]
        assert noted(folder) == texts(1, 2)
        assert verify_survey(folder).faults == []
        shutil.rmtree(str(folder.parent))
        if ending == DONE:
            break
    assert number > 20


def cut_power(folder, place, failure, work):
    """Do some work on a disk that loses its power; return whether it was done before that."""
    disk = FailingDisk(folder)
    try:
        disk.begin(failure, place)
        with contextlib.suppress(StorageFailedError):
            work()
        done = not disk.has_failed
        disk.end()
        return done
    finally:
        disk.release()


def test_an_opening_that_failed_half_way_is_repeated_with_the_same_id(tmp_path):
    """At every call, in the same process or in the next one."""
    folder = None
    for calls in itertools.count():
        data = tmp_path / str(calls)
        data.mkdir()
        kit, disk = Kit(data, check_data=lambda: None), FailingDisk(data)
        try:
            disk.begin(Failure(calls, False), data)
            with contextlib.suppress(StorageFailedError):
                folder = kit.open(metadata_json=METADATA)
        finally:
            disk.release()
        if folder:
            break
        if calls % 2:
            kit.processing.shut_down()
            kit = Kit(data, check_data=lambda: None)
        again = kit.open(metadata_json=METADATA)
        kit.finish(TRACES, ())
        kit.processing.shut_down()
        assert verify_survey(again).status == COMPLETE, calls
    kit.processing.shut_down()
    assert calls > 8


@pytest.mark.parametrize("damaged", ["", *FILES])
def test_a_power_cut_at_any_call_adds_a_fact_whole_or_not_and_leaves_it_intact(
    copies, tmp_path, damaged
):
    """Even where the disk loses all that was not made durable, or a part of it."""
    whole, seen = copies("finished"), set()
    for calls in numbers(1 if damaged == "" else 3):
        place, after = tmp_path / f"{calls} before", tmp_path / f"{calls} after"
        folder, left = place / whole.name, after / whole.name
        shutil.copytree(str(whole), str(folder))
        if damaged in FILES:
            change_digit(folder, damaged, 1)
        chance = random.Random(f"{SEED} {calls}")
        failure = Failure(calls - 1, True, chance.choice([0.0, 0.5, 1.0]), chance.randrange(100))
        done = cut_power(
            place, after, failure, lambda folder=folder: add_to_survey(folder, add_marker(3), NOW)
        )
        count = len(noted(left))
        seen.add(count)
        assert count == 3 if done else count in (2, 3)
        found = verify_survey(left)
        assert damaged in FILES or (found.status, found.faults) == (COMPLETE, [])
        for number in (3, 4):
            add_to_survey(left, add_marker(number), NOW)
        assert noted(left) == texts(1, 2, 3, 4)
        found = verify_survey(left)
        assert (found.status, found.faults) == (COMPLETE, [])
        if done:
            break
    assert seen == {2, 3} and calls > 1


def test_an_entry_that_was_torn_while_it_was_added_leaves_a_sealed_survey_intact(copies):
    folder = copies("finished")
    before = (folder / "log.jsonl").read_bytes()
    add_to_survey(folder, add_marker(3), NOW)
    line = (folder / "log.jsonl").read_bytes()[len(before) :]
    for torn in (line[:1], line[: len(line) // 2], line[:-2], bytes(200)):
        (folder / "log.jsonl").write_bytes(before + torn)
        (folder / "log.copy.jsonl").write_bytes(before)
        found = verify_survey(folder)
        assert (found.status, found.faults) == (COMPLETE, [])
        add_to_survey(folder, add_marker(4), NOW)
        assert noted(folder) == texts(1, 2, 4)
        assert verify_survey(folder).status == COMPLETE


def test_a_folder_that_holds_anything_else_is_not_emptied_by_an_opening(copies):
    folder = copies("stopped")
    for name in (*FILES, "manifest.json"):
        (folder / name).unlink()
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    kit = Kit(folder.parent)
    with raises_fault("survey.no_plan"):
        kit.open(metadata_json=METADATA)
    kit.processing.shut_down()
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
