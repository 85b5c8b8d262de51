"""The log of a survey: records that judge themselves, in two files of which each is enough.

The manifest seals it, covers itself to the last bit, and is read as earlier versions wrote it."""

import hashlib
import json
import random
from dataclasses import replace

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from log_examples import (
    EARLIER,
    NOW,
    add_marker,
    entries,
    flipped,
    make_former,
    make_survey,
    with_own_sum,
    write_log,
)
from run_seed import SEED, draws

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest, survey_log, survey_metadata
from gpr20_survey.folder.annotating import add_to_survey
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
from gpr20_survey.folder.recovery import recover

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


RECORD = LogRecord.after(None, Kind.MARKER, {"x": 1}, NOW).as_json()


@each_case(
    "values",
    [
        *({**RECORD, "number": wrong} for wrong in (-1, True, 1.0, MAX_NUMBER + 1)),
        *({**RECORD, "values": wrong} for wrong in (None, [])),
        *({**RECORD, name: None} for name in ("time", "previous")),
        *({**RECORD, **wrong} for wrong in ({"sha256": 5}, {"kind": "plan "}, {"more": 1})),
        *({name: RECORD[name] for name in KEYS if name != absent} for absent in KEYS),
        dict(reversed(list(RECORD.items()))),
    ],
)
def test_what_is_no_record_is_none(values):
    assert record_of(RECORD) is not None
    assert record_of(values) is None


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


def test_an_empty_report_can_not_be_put_in_the_place_of_the_last_one(tmp_path):
    """Its checksum cannot be calculated, and no record behind it names it."""
    log = write_log(tmp_path)
    last = log.add(log.next(Kind.REPORT, {"verdict": "the last"}, NOW))
    forged = [*log.records[:-1], last.without_values()]
    (tmp_path / "log.jsonl").write_bytes(b"".join(one.line() for one in forged))
    (tmp_path / "survey.json").write_bytes(view_of(forged))
    found = read_log(tmp_path)
    assert forged[-1] not in found.records
    assert found.lost == (last.number,)


@pytest.mark.parametrize("limit", ["MAX_LOG_BYTES", "MAX_FILE_BYTES"])
def test_a_log_that_is_full_takes_no_more_facts_but_the_end_and_stays_readable(
    tmp_path, monkeypatch, limit
):
    log = write_log(tmp_path)
    module = survey_log if limit == "MAX_LOG_BYTES" else survey_metadata
    monkeypatch.setattr(module, limit, 60_000)
    monkeypatch.setattr(survey_log, "RESERVED_BYTES", 20_000)
    with raises_fault("storage.request_refused", 40_000, error=SurveyRefusedError):
        for _ in range(1000):
            log.add(log.next(Kind.PAUSE, {"reason": "x" * 4000}, NOW))
    assert read_log(tmp_path).is_whole and read_log(tmp_path).records == log.records
    log.add(log.next(Kind.END, {"outcome": "stopped"}, NOW))
    assert read_log(tmp_path).is_whole and read_log(tmp_path).records == log.records


@pytest.fixture
def folder(tmp_path):
    make_survey(tmp_path / "survey")
    return tmp_path / "survey"


def test_the_manifest_names_the_log_by_its_last_record_and_is_read_as_it_was_written(folder):
    sealed = manifest.read_manifest(folder)
    last = recover(folder).found.records[-1]
    assert (sealed.log, sealed.next_log) == ((last.number, last.sha256), None)
    assert set(sealed.files) == {"traces/one.json"}
    sealed = replace(
        sealed,
        next_log=manifest.LogHead(4, "a" * 64),
        unconfirmed=("record 3", "markers/1"),
        reopened=NOW,
        rewritten=({"time": NOW, "reason": "it was missing"},),
    )
    assert manifest.decode(sealed.encode()) == sealed


def test_every_bit_of_a_manifest_is_covered(folder):
    whole, chance = (folder / "manifest.json").read_bytes(), random.Random(SEED)
    assert manifest.decode(whole).covers_itself
    for _ in range(draws(50)):
        for damaged in (flipped(chance, whole), whole[: chance.randrange(len(whole))]):
            with pytest.raises(manifest.ManifestDamagedError):
                manifest.decode(damaged)


@each_case("key", ["rewritten", "files", "survey_id", "log", "next_log", "unconfirmed"])
@each_case("value", [1, [1], "x", {"number": -1, "sha256": "a"}, {"number": 1, "sha256": 1}])
def test_a_manifest_with_entries_of_another_type_is_damaged(folder, key, value):
    values = json.loads((folder / "manifest.json").read_text())
    if type(value) is type(values[key]) and key not in ("log", "next_log", "rewritten"):
        value = 2.5
    del values["sha256"]
    with pytest.raises(manifest.ManifestDamagedError):
        manifest.decode(with_own_sum({**values, key: value}))


@pytest.mark.parametrize("form", EARLIER)
def test_a_manifest_of_an_earlier_version_is_read_and_replaced_by_the_next_addition(folder, form):
    former = make_former(folder, form)
    sealed = manifest.read_manifest(folder)
    assert sealed.log is None and sealed.covers_itself is (form != EARLIER[0])
    assert sealed.matches("survey.json", file_sums.sum_of_file(folder / "survey.json"))
    add_to_survey(folder, add_marker(7), NOW)
    sealed, found = manifest.read_manifest(folder), recover(folder)
    assert sealed.covers_itself and sealed.covers(found.found.records)
    for name in sealed.files:
        assert sealed.matches(name, file_sums.sum_of_file(folder / name))
    assert found.found.records[0].values == former
    assert found.all_unconfirmed == {}
