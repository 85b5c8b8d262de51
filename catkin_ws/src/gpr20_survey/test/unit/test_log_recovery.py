"""A log that is damaged: each form repairs the other, and what is lost is named for ever."""

from __future__ import annotations

import itertools
import json
import os
import random
import shutil

import pytest
from fault_kit import raises_fault
from log_examples import (
    FILES,
    NOW,
    add_marker,
    assert_everything_acknowledged,
    both_files,
    change_digit,
    entries,
    facts,
    make_survey,
    marker,
    recovered,
)
from run_seed import SEED

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import manifest, sealing
from gpr20_survey.folder.annotating import add_to_survey
from gpr20_survey.folder.log_content import view_of
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import open_log, recover
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.plan.markers import markers_of

DAMAGES = int(os.environ.get("GPR20_DAMAGES", "120"))


@pytest.fixture(params=[True, False], ids=["sealed", "cut off"])
def folder(tmp_path, request):
    make_survey(tmp_path / "survey", request.param)
    return tmp_path / "survey"


@pytest.fixture
def sealed(tmp_path):
    make_survey(tmp_path / "survey")
    return tmp_path / "survey"


def covers(folder):
    return manifest.read_manifest(folder).covers(recovered(folder).found.records)


def reopened(folder):
    """Do with the log what resuming a survey does; return what is there afterwards."""
    log = open_log(folder, recover(folder), NOW)
    log.add(log.next(Kind.RESUME, {"stored_traces": 0}, NOW))
    after = recovered(folder)
    assert after.found.is_whole
    return after


def names_of_lost(found):
    return {one for one in found.all_unconfirmed if one.startswith("record ")}


@pytest.mark.parametrize("name", FILES)
def test_a_flip_of_any_byte_of_one_form_is_found_and_loses_nothing(folder, name):
    whole = (folder / name).read_bytes()
    chance = random.Random(SEED)
    for place in chance.sample(range(len(whole)), DAMAGES):
        content = bytearray(whole)
        content[place] ^= 1 << chance.randrange(8)
        (folder / name).write_bytes(content)
        found = recovered(folder)
        assert not found.found.is_whole, (SEED, place)
        assert_everything_acknowledged(found)
    (folder / name).write_bytes(whole)
    assert recovered(folder).found.is_whole


def damage(chance, content):
    """Cut, overwrite, delete, insert or empty."""
    start = chance.randrange(len(content))
    end = min(len(content), start + chance.choice([1, 30, 500, 5000]))
    more = bytes(chance.randrange(256) for _ in range(end - start))
    return chance.choice(
        [
            content[:start],
            content[:start] + more + content[end:],
            content[:start] + bytes(end - start) + content[end:],
            content[:start] + content[end:],
            content[:start] + more + content[start:],
            b"",
        ]
    )


@pytest.mark.parametrize("name", FILES)
def test_any_damage_of_one_form_is_repaired_by_the_next_addition(folder, name):
    before = both_files(folder)
    others = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for number in range(DAMAGES // 4):
        chance = random.Random(f"{SEED} {number}")
        damaged = damage(chance, before[name])
        if damaged == before[name]:
            continue
        (folder / name).write_bytes(damaged)
        assert_everything_acknowledged(recovered(folder))
        add_to_survey(folder, add_marker(7), NOW)
        found = recovered(folder)
        assert found.found.is_whole, (SEED, number)
        *former, last = markers_of(found.description)
        assert len(former) == 3 and last.same_request(marker(7))
        if (folder / "manifest.json").exists():
            assert covers(folder)
        shutil.rmtree(str(folder))
        for path, content in others.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)


@pytest.mark.parametrize("name", FILES)
def test_a_form_that_is_missing_loses_nothing(folder, name):
    (folder / name).unlink()
    assert_everything_acknowledged(recovered(folder))
    add_to_survey(folder, add_marker(7), NOW)
    assert recovered(folder).found.is_whole
    assert len(markers_of(recovered(folder).description)) == 4


def test_a_cut_at_any_byte_of_the_last_line_loses_nothing(folder):
    path = folder / "log.jsonl"
    whole = path.read_bytes()
    start = whole.rindex(b"\n", 0, -1) + 1
    for cut in range(start, len(whole)):
        path.write_bytes(whole[:cut])
        found = recovered(folder)
        assert not found.found.is_whole and not found.found.damage
        assert_everything_acknowledged(found)


def test_different_records_damaged_in_the_two_forms_are_all_right(folder):
    change_digit(folder, "log.jsonl", 1)
    change_digit(folder, "survey.json", 3)
    found = recovered(folder)
    assert len(found.found.damage) == 2
    assert_everything_acknowledged(found)
    assert markers_of(reopened(folder).description) == markers_of(found.description)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_record_damaged_in_both_forms_is_named_for_ever_and_never_used(folder, number):
    for name in FILES:
        change_digit(folder, name, number)
    wanted = next(
        one["number"]
        for one in entries(folder)
        if one["kind"] == "marker" and one["values"]["marker_id"] == marker(number).marker_id
    )
    found = recovered(folder)
    assert found.found.lost == (wanted,)
    with raises_fault("survey.description_damaged", error=SurveyRefusedError):
        add_to_survey(folder, add_marker(7), NOW)
    # As often as it is opened again.
    for _ in range(3):
        found = reopened(folder)
        entry = found.all_unconfirmed[f"record {wanted}"]
        assert len(entry["found"]) == 2
        assert all(f"9{str(marker(number).x_mm)[1:]}" in text for text in entry["found"])
        ids = {one.marker_id for one in markers_of(found.description)}
        assert marker(number).marker_id not in ids and len(ids) == 2


def test_the_last_record_damaged_in_both_forms_is_named(folder):
    log = SurveyLog(folder, recovered(folder).found.records, whole=True)
    if (folder / "manifest.json").exists():
        sealing.add_sealed(
            folder, manifest.read_manifest(folder), log, log.next(Kind.AUDIT, {"by": "Ana"}, NOW)
        )
    else:
        log.add(log.next(Kind.AUDIT, {"by": "Ana"}, NOW))
    for name in FILES:
        path = folder / name
        path.write_bytes(path.read_bytes().replace(b'"Ana"\n', b'"Eva"\n').replace(
            b'"by":"Ana"', b'"by":"Eva"').replace(b'"by": "Ana"', b'"by": "Eva"'))  # fmt: skip
    last = log.last.number
    assert recovered(folder).found.lost == (last,)
    found = reopened(folder)
    assert names_of_lost(found) == {f"record {last}"}
    assert "Eva" in str(found.all_unconfirmed)
    # Nothing else gets the number of what is lost.
    assert [one.number for one in found.found.records[-2:]] == [last + 1, last + 2]


@pytest.mark.parametrize("lines", [1, 2, 3])
@pytest.mark.parametrize("damage", [lambda line: b"#" + line[1:], lambda line: line[:-2] + b"#}"])
def test_last_lines_that_are_damaged_are_named_if_survey_json_is_gone(tmp_path, lines, damage):
    make_survey(tmp_path / "survey", sealed=False)
    folder = tmp_path / "survey"
    content = (folder / "log.jsonl").read_bytes().splitlines()
    content[-lines:] = map(damage, content[-lines:])
    (folder / "log.jsonl").write_bytes(b"\n".join([*content, b""]))
    (folder / "survey.json").write_bytes(b"{")
    expected = tuple(range(len(content) - lines, len(content)))
    assert recovered(folder).found.lost == expected
    assert names_of_lost(reopened(folder)) == {f"record {number}" for number in expected}


def test_a_byte_that_makes_two_lines_of_the_last_one_makes_no_record_more(folder):
    path = folder / "log.jsonl"
    content = path.read_bytes()
    path.write_bytes(content[:-100] + b"\n" + content[-99:])
    assert recovered(folder).found.lost == ()
    assert_everything_acknowledged(recovered(folder))


def test_records_that_only_the_manifest_knows_of_are_named(sealed):
    """A log that was cut off at a line, beside a survey.json that cannot be read."""
    lines = (sealed / "log.jsonl").read_bytes().splitlines(keepends=True)
    (sealed / "log.jsonl").write_bytes(b"".join(lines[:-3]))
    (sealed / "survey.json").write_bytes(b"")
    expected = tuple(range(len(lines) - 3, len(lines)))
    assert recovered(sealed).found.lost == expected
    assert names_of_lost(reopened(sealed)) == {f"record {number}" for number in expected}


def test_of_forms_of_two_logs_the_records_of_one_are_used_and_those_of_the_other_named(folder):
    found = recovered(folder).found
    common = found.records[:3]
    other = SurveyLog(folder.parent, common, whole=False)
    for number in (11, 12):
        values = {**facts()[2].values, **marker(number).__dict__}
        other.take(other.next(Kind.MARKER, values, NOW))
    (folder / "survey.json").write_bytes(view_of(other.records))
    after = reopened(folder)
    assert_after = {one.marker_id for one in markers_of(after.description)}
    assert {marker(number).marker_id for number in (1, 2, 3)} == assert_after
    for one in other.records[3:]:
        assert f"record {one.number}, {one.sha256[:8]}" in after.all_unconfirmed
    for number in (11, 12):
        assert marker(number).marker_id in str(after.all_unconfirmed)


def test_the_log_of_another_survey_is_never_mixed_in(folder):
    content = json.loads((folder / "survey.json").read_text())
    other = SurveyLog(folder.parent, [], whole=False)
    plan = {**recovered(folder).found.records[0].values, "software_revision": "9"}
    other.take(other.next(Kind.PLAN, plan, NOW))
    for one in content["log"][1:4]:
        other.take(other.next(Kind(one["kind"]), one["values"] or {}, NOW))
    (folder / "survey.json").write_bytes(view_of(other.records))
    found = recovered(folder)
    assert found.found.records[0] not in other.records or len(found.found.records) == 4
    numbers = [one.number for one in found.found.records]
    assert len(numbers) == len(set(numbers))
    previous = [one.previous for one in found.found.records[1:]]
    assert previous == [one.sha256 for one in found.found.records[:-1]]
    assert found.all_unconfirmed


def test_damage_in_both_forms_at_random_is_never_called_intact_and_never_wrong(folder):
    expected = {one.sha256 for one in recovered(folder).found.records}
    before = both_files(folder)
    everything = set(range(len(expected)))
    for number in range(DAMAGES):
        chance = random.Random(f"{SEED} both {number}")
        for name in FILES:
            content = bytearray(before[name])
            for _ in range(chance.choice([1, 1, 2, 20])):
                content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
            (folder / name).write_bytes(content)
        try:
            found = recover(folder)
        except SurveyRefusedError as error:
            assert error.message.fault_code == "survey.description_lost"
            continue
        assert not found.found.is_whole, (SEED, number)
        present = {one.number for one in found.found.records}
        assert {one.sha256 for one in found.found.records} <= expected, (SEED, number)
        if found.found.has_log and present != everything:
            assert found.found.lost, (SEED, number)
        if (folder / "manifest.json").exists() and found.found.has_log:
            assert present | set(found.found.lost) == everything, (SEED, number)
    for name, content in before.items():
        (folder / name).write_bytes(content)


def test_a_wrong_number_of_an_entry_without_values_hides_and_invents_no_record(sealed):
    """The checksum of such an entry cannot be calculated: its number may be any."""
    before = both_files(sealed)
    everything = recovered(sealed).found.records
    shown = [one for one in json.loads(before["survey.json"])["log"] if one["values"] is None]
    assert shown
    for one, number, damaged in itertools.product(shown, (0, 7, 8, 90, 999_999), range(1, 10)):
        old, new = (b'"number": %d,' % value for value in (one["number"], number))
        (sealed / "survey.json").write_bytes(before["survey.json"].replace(old, new))
        lines = before["log.jsonl"].splitlines(keepends=True)
        lines[damaged] = lines[damaged].replace(b"2026", b"2027")
        (sealed / "log.jsonl").write_bytes(b"".join(lines))
        found = recovered(sealed).found
        # Of those that have their values in survey.json, none is lost.
        assert set(found.lost) <= {damaged} & {entry["number"] for entry in shown}
        assert {one.sha256 for one in found.records} <= {one.sha256 for one in everything}


def test_a_crash_while_the_log_is_repaired_forgets_nothing_that_is_lost(folder, tmp_path):
    for name in FILES:
        change_digit(folder, name, 3)
    expected = names_of_lost(recovered(folder))
    assert len(expected) == 1
    number, ended = 0, False
    while not ended:
        number += 1
        copy = tmp_path / str(number)
        shutil.copytree(str(folder), str(copy))
        child = os.fork()
        if not child:
            try:
                die_at(number)
                reopened(copy)
            finally:
                os._exit(0)
        os.waitpid(child, 0)
        ended = (
            names_of_lost(recovered(copy)) == expected
            and recovered(copy).found.is_whole
            and (len(recovered(copy).description.get("resumed", [])) == 1)
        )
        assert names_of_lost(recovered(copy)) == expected, number
        assert names_of_lost(reopened(copy)) == expected, number
        assert number < 100
    assert number > 5


def die_at(number):
    """Let this process die in its n-th call of the disk."""
    calls = []

    def dying(real):
        def call(*arguments, **options):
            calls.append(real)
            if len(calls) == number:
                os._exit(9)
            return real(*arguments, **options)

        return call

    for name in ("write", "pwrite", "fsync", "replace", "unlink", "link", "mkdir"):
        setattr(os, name, dying(getattr(os, name)))


def test_a_crash_at_any_call_of_the_disk_adds_a_fact_whole_or_not_at_all(sealed, tmp_path):
    number, seen = 0, []
    while not seen or seen[-1] != "done":
        number += 1
        copy = tmp_path / str(number)
        shutil.copytree(str(sealed), str(copy))
        child = os.fork()
        if not child:
            try:
                die_at(number)
                add_to_survey(copy, add_marker(7), NOW)
                os._exit(0)
            finally:
                os._exit(1)
        ending = os.WEXITSTATUS(os.waitpid(child, 0)[1])
        assert ending in (0, 9)
        found = recovered(copy)
        assert covers(copy) and not found.found.damage and not found.found.lost, number
        markers = markers_of(found.description)
        assert len(markers) in (3, 4) and markers[:3] == markers_of(recovered(sealed).description)
        assert ending == 9 or len(markers) == 4
        seen += [len(markers)] if ending == 9 else [len(markers), "done"]
        add_to_survey(copy, add_marker(8), NOW)
        assert covers(copy) and recovered(copy).found.is_whole
        assert manifest.read_manifest(copy).next_log is None
        shutil.rmtree(str(copy))
    assert 3 in seen[:-2] and 4 in seen[:-2]


def test_a_number_that_is_far_too_large_does_not_fill_the_memory(folder):
    line = (
        b'{"number":999999999999,"time":"","kind":"marker","values":{},"previous":"","sha256":""}\n'
    )
    with (folder / "log.jsonl").open("ab") as stream:
        stream.write(line)
    assert len(recovered(folder).found.lost) <= 1
