"""A log that is damaged: each file repairs the other, and what is lost is named for ever."""

import random
import shutil

import pytest
from fault_kit import raises_fault
from log_examples import (
    DONE,
    FILES,
    KILLED,
    NOW,
    add_marker,
    assert_everything_acknowledged,
    both_files,
    change_digit,
    damaged,
    ended_at_call,
    entries,
    flipped,
    make_survey,
    marker,
)
from run_seed import SEED, draws

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import manifest
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import add_to_survey, open_log, recover
from gpr20_survey.plan.markers import markers_of


@pytest.fixture(params=[True, False], ids=["sealed", "cut off"])
def folder(tmp_path, request):
    make_survey(tmp_path / "survey", request.param)
    return tmp_path / "survey"


def reopened(folder):
    """Do with the log what resuming a survey does; return what is there afterwards."""
    log = open_log(folder, recover(folder), NOW)
    log.add(log.next(Kind.RESUME, {"stored_traces": 0}, NOW))
    after = recover(folder)
    assert after.found.is_whole
    return after


@pytest.mark.parametrize("count", [900, 5000])
def test_the_record_of_what_is_lost_can_be_read_however_much_it_is(folder, count):
    plan = (folder / FILES[0]).read_bytes().splitlines(keepends=True)[0]
    garbage = [b'{"number":%d,' % number + b"\xff" * 20_000 for number in range(1, count)]
    for name in FILES:
        (folder / name).write_bytes(plan + b"\n".join(garbage[:900]) + b"\n#" * (count - 900))
    found = reopened(folder)
    assert not found.found.lost
    reason = " ".join(str(one["reason"]) for one in found.description["unconfirmed"].values())
    assert "its checksum is wrong" in reason
    assert len((folder / FILES[0]).read_bytes()) < 5_000_000


def names_of_lost(found):
    return {one for one in found.description["unconfirmed"] if one.startswith("record ")}


@pytest.mark.parametrize("name", FILES)
def test_any_damage_of_one_file_is_repaired_by_the_next_addition(folder, name, tmp_path):
    chance, contents = random.Random(SEED), [None]
    whole = (folder / name).read_bytes()
    contents += [damaged(chance, whole) for _ in range(draws(10))]
    for number, content in enumerate(one for one in contents if one != whole):
        copy = tmp_path / str(number)
        shutil.copytree(str(folder), str(copy))
        (copy / name).unlink() if content is None else (copy / name).write_bytes(content)
        found = recover(copy)
        assert not found.found.is_whole
        assert_everything_acknowledged(found)
        add_to_survey(copy, add_marker(7), NOW)
        found = recover(copy)
        assert found.found.is_whole
        *former, last = markers_of(found.description)
        assert len(former) == 3 and last.same_request(marker(7))
        if (copy / "manifest.json").exists():
            assert manifest.read_manifest(copy).covers(found.found.records)


def test_a_cut_anywhere_behind_the_plan_loses_nothing(folder):
    path = folder / "log.jsonl"
    whole, is_sealed = path.read_bytes(), (folder / "manifest.json").exists()
    start = whole.index(b"\n") + 1
    for cut in [start, *random.Random(SEED).sample(range(start, len(whole)), draws(12))]:
        path.write_bytes(whole[:cut])
        found = recover(folder)
        # Both files held what the manifest names.
        named = (path.name,)
        assert found.found.damaged == (named if is_sealed else ())
        assert found.found.behind == (() if is_sealed else named)
        assert_everything_acknowledged(found)
    # Nor does a byte that makes two lines of it.
    path.write_bytes(whole[:-100] + b"\n" + whole[-99:])
    assert recover(folder).found.lost == ()
    assert_everything_acknowledged(recover(folder))


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_record_damaged_in_both_files_is_named_for_ever_and_never_used(folder, number):
    for name in FILES:
        change_digit(folder, name, number)
    wanted = next(
        one["number"]
        for one in entries(folder)
        if one["kind"] == "marker" and one["values"]["marker_id"] == marker(number).marker_id
    )
    assert recover(folder).found.lost == (wanted,)
    with raises_fault("survey.can_resume", error=SurveyRefusedError):
        add_to_survey(folder, add_marker(7), NOW)
    # As often as it is opened again.
    for _ in range(3):
        found = reopened(folder)
        assert f"record {wanted}" in found.description["unconfirmed"]
        left = (folder / "damaged" / FILES[0]).read_text()
        assert f"9{str(marker(number).x_mm)[1:]}" in left
        ids = {one.marker_id for one in markers_of(found.description)}
        assert marker(number).marker_id not in ids and len(ids) == 2


def test_no_damage_of_both_files_hides_or_invents_a_record(folder):
    before, records, chance = both_files(folder), recover(folder).found.records, random.Random(SEED)
    everything, expected = {one.number for one in records}, {one.sha256 for one in records}
    for _ in range(draws(30)):
        for name in FILES:
            content = before[name]
            for _flip in range(chance.choice([1, 1, 2, 20])):
                content = flipped(chance, content)
            (folder / name).write_bytes(content)
        try:
            found = recover(folder)
        except SurveyRefusedError as error:
            assert error.message.fault_code == "survey.log_lost"
            continue
        assert not found.found.is_whole
        present = {one.number for one in found.found.records}
        assert {one.sha256 for one in found.found.records} <= expected
        if present != everything:
            assert found.found.lost
        if (folder / "manifest.json").exists():
            assert present | set(found.found.lost) == everything


def test_a_number_that_is_far_too_large_does_not_fill_the_memory(folder):
    line = (
        b'{"number":999999999999,"time":"","kind":"marker","values":{},"previous":"","sha256":""}\n'
    )
    with (folder / "log.jsonl").open("ab") as stream:
        stream.write(line)
    assert len(recover(folder).found.lost) <= 1


def test_a_crash_while_the_log_is_repaired_forgets_nothing_that_is_lost(folder, tmp_path):
    for name in FILES:
        change_digit(folder, name, 3)
    expected = names_of_lost(recover(folder))
    assert len(expected) == 1
    ending, number = KILLED, 0
    while ending == KILLED:
        number += 1
        copy = tmp_path / str(number)
        shutil.copytree(str(folder), str(copy))
        ending = ended_at_call(number, lambda copy=copy: reopened(copy))
        assert ending in (DONE, KILLED)
        assert names_of_lost(recover(copy)) == expected
        assert names_of_lost(reopened(copy)) == expected
    assert 5 < number < 100
