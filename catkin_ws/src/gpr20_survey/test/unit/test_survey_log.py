"""The log of a survey: records that judge themselves, in two files of which each is enough."""

from __future__ import annotations

import hashlib
import json
import os
import random

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from log_examples import NOW, PLAN, entries, facts, make_survey, write_log

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_log, survey_metadata
from gpr20_survey.folder.log_content import description_of, view_of
from gpr20_survey.folder.log_reading import read_log
from gpr20_survey.folder.log_record import (
    KEYS,
    MAX_NUMBER,
    Kind,
    LogRecord,
    record_of,
    record_of_line,
)
from gpr20_survey.folder.survey_log import SurveyLog

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)  # fmt: skip
OBJECTS = st.dictionaries(st.text(max_size=8), JSON, max_size=4)


@given(st.sampled_from(Kind), OBJECTS, st.text(max_size=30))
def test_a_record_is_the_same_behind_a_line_and_behind_an_entry(kind, values, time):
    record = LogRecord.after(None, kind, values, time)
    assert record_of_line(record.line()[:-1]) == record
    assert record_of(json.loads(json.dumps(record.as_json(), indent=2))) == record


@given(OBJECTS, st.integers(0, 10**6), st.integers(1, 255))
def test_no_byte_of_a_line_can_change_unseen(values, place, change):
    line = bytearray(LogRecord.after(None, Kind.MARKER, values, NOW).line()[:-1])
    line[place % len(line)] ^= change
    assert record_of_line(bytes(line)) is None


def test_records_are_numbered_and_each_names_the_one_before():
    log = [LogRecord.after(None, Kind.PLAN, PLAN, NOW)]
    for fact in facts():
        log.append(LogRecord.after(log[-1], fact.kind, fact.values, NOW))
    assert [one.number for one in log] == list(range(len(log)))
    assert [one.previous for one in log] == ["", *(one.sha256 for one in log[:-1])]


@each_case(
    "change",
    [
        {"number": -1},
        {"number": True},
        {"number": 1.0},
        {"number": MAX_NUMBER + 1},
        {"time": None},
        {"values": None},
        {"values": []},
        {"sha256": 5},
        {"previous": None},
        {"kind": "plan "},
        {"more": 1},
    ],
)
def test_what_is_no_record_is_none(change):
    assert record_of({**LogRecord.after(None, Kind.MARKER, {"x": 1}, NOW).as_json(), **change}) is (
        None
    )


def test_an_entry_in_another_order_or_without_a_key_is_no_record():
    values = LogRecord.after(None, Kind.MARKER, {"x": 1}, NOW).as_json()
    assert record_of(dict(reversed(list(values.items())))) is None
    for key in KEYS:
        assert record_of({name: one for name, one in values.items() if name != key}) is None


def test_a_record_of_a_kind_of_a_later_version_is_kept_and_changes_nothing(tmp_path):
    log = write_log(tmp_path)
    before = log.description
    values = [log.last.number + 1, NOW, "later", {"x": 1}, log.last.sha256]
    covered = json.dumps(values, separators=(",", ":")).encode()
    later = log.add(LogRecord(*values, hashlib.sha256(covered).hexdigest()))
    found = read_log(tmp_path)
    assert found.is_whole and found.records[-1] == later
    assert description_of(found.records) == before


def test_the_content_of_survey_json_follows_from_the_log_alone(tmp_path):
    log = make_survey(tmp_path / "survey")
    assert (tmp_path / "survey" / "survey.json").read_bytes() == view_of(log.records)
    values = json.loads((tmp_path / "survey" / "survey.json").read_text())
    shown = values.pop("log")
    assert values == log.description
    assert [one["number"] for one in shown] == list(range(len(log.records)))


def test_reports_that_a_later_one_replaced_are_in_the_log_alone(tmp_path):
    write_log(tmp_path)
    reports = [one["values"] for one in entries(tmp_path) if one["kind"] == "report"]
    assert reports == [None, None, {"verdict": "all", "coverage": "mm"}]
    lines = (tmp_path / "log.jsonl").read_bytes().splitlines()
    logged = [json.loads(one)["values"] for one in lines if b'"kind":"report"' in one]
    assert [one["verdict"] for one in logged] == ["none", "some", "all"]


def test_a_log_made_again_of_survey_json_alone_is_whole(tmp_path):
    expected = write_log(tmp_path).description
    view = (tmp_path / "survey.json").read_bytes()
    (tmp_path / "log.jsonl").unlink()
    found = read_log(tmp_path)
    assert (found.lost, description_of(found.records)) == ((), expected)
    SurveyLog(tmp_path, found.records, whole=False).write()
    again = read_log(tmp_path)
    assert again.is_whole and description_of(again.records) == expected
    assert (tmp_path / "survey.json").read_bytes() == view
    log = SurveyLog(tmp_path, again.records, whole=True)
    log.add(log.next(Kind.REPORT, {"verdict": "later"}, NOW))
    assert read_log(tmp_path).is_whole


def test_an_empty_report_can_not_be_put_in_the_place_of_the_last_one(tmp_path):
    """Its checksum cannot be calculated, and no record behind it names it."""
    log = write_log(tmp_path)
    last = log.add(log.next(Kind.REPORT, {"verdict": "the last"}, NOW))
    forged = last.without_values()
    for path, content in (
        (tmp_path / "log.jsonl", b"".join(one.line() for one in [*log.records[:-1], forged])),
        (tmp_path / "survey.json", view_of([*log.records[:-1], forged])),
    ):
        path.write_bytes(content)
    found = read_log(tmp_path)
    assert forged not in found.records
    assert found.lost == (last.number,)


@pytest.mark.parametrize("name", ["fsync", "write", "replace"])
def test_a_disk_that_refuses_leaves_the_former_records_and_the_call_may_be_repeated(
    tmp_path, monkeypatch, name
):
    log = write_log(tmp_path)
    before = log.records
    real, number, refused = getattr(os, name), 0, 0
    while True:
        number += 1
        calls = []

        def refuse(*arguments, calls=calls, number=number):
            calls.append(arguments)
            if len(calls) == number:
                raise OSError(28, "No space left on device")
            return real(*arguments)

        record = log.next(Kind.MARKER, {"attempt": number}, NOW)
        with monkeypatch.context() as patch:
            patch.setattr(os, name, refuse)
            try:
                log.add(record)
                break
            except OSError:
                refused += 1
        assert log.records == before
        assert read_log(tmp_path).records[: len(before)] == before
    assert refused
    found = read_log(tmp_path)
    assert found.is_whole and found.records == (*before, record)


@pytest.mark.parametrize("limit", ["MAX_LOG_BYTES", "MAX_FILE_BYTES"])
def test_a_log_that_is_full_takes_no_more_facts_but_the_end_and_stays_readable(
    tmp_path, monkeypatch, limit
):
    log = write_log(tmp_path)
    module = survey_log if limit == "MAX_LOG_BYTES" else survey_metadata
    monkeypatch.setattr(module, limit, 200_000)
    monkeypatch.setattr(survey_log, "RESERVED_BYTES", 50_000)
    with raises_fault("storage.request_refused", 150_000, error=SurveyRefusedError):
        for _ in range(1000):
            log.add(log.next(Kind.PAUSE, {"reason": "x" * 1000}, NOW))
    assert read_log(tmp_path).is_whole and read_log(tmp_path).records == log.records
    log.add(log.next(Kind.END, {"outcome": "stopped"}, NOW))
    assert read_log(tmp_path).is_whole and read_log(tmp_path).records == log.records


def test_each_random_log_is_read_as_it_was_written(tmp_path):
    for seed in range(30):
        chance = random.Random(seed)
        folder = tmp_path / str(seed)
        folder.mkdir()
        log = SurveyLog(folder, [LogRecord.after(None, Kind.PLAN, PLAN, NOW)], whole=False)
        log.write()
        for _ in range(chance.randrange(30)):
            fact = chance.choice(facts())
            log.add(log.next(fact.kind, fact.values, NOW))
        found = read_log(folder)
        assert found.is_whole, seed
        assert [one.sha256 for one in found.records] == [one.sha256 for one in log.records], seed
