"""The log of a survey: records that judge themselves, in two files of which each is enough.

The manifest seals it, and covers itself to the last bit."""

import hashlib
import json
import random

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from log_examples import (
    FILES,
    NOW,
    add_marker,
    both_files,
    flipped,
    make_survey,
    with_own_sum,
    write_log,
)
from run_seed import SEED, draws

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import manifest, survey_log
from gpr20_survey.folder.log_record import (
    MAX_NUMBER,
    Kind,
    LogHead,
    LogRecord,
    description_of,
    record_of_line,
)
from gpr20_survey.folder.recovery import add_to_survey, recover
from gpr20_survey.folder.survey_log import read_log

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)  # fmt: skip
OBJECTS = st.dictionaries(st.text(max_size=8), JSON, max_size=4)


@given(st.sampled_from(Kind), OBJECTS, st.text(max_size=30))
def test_a_record_is_the_same_behind_its_line(kind, values, time):
    record = LogRecord.after(None, kind, values, time)
    assert record_of_line(record.line()[:-1]) == record


@given(OBJECTS, st.integers(0, 10**6), st.integers(1, 255))
def test_no_byte_of_a_line_can_change_unseen(values, place, change):
    line = bytearray(LogRecord.after(None, Kind.MARKER, values, NOW).line()[:-1])
    line[place % len(line)] ^= change
    assert record_of_line(bytes(line)) is None


RECORD = LogRecord.after(None, Kind.MARKER, {"x": 1}, NOW).as_json()


def line_of(values):
    return json.dumps(values, separators=(",", ":")).encode()


@each_case(
    "values",
    [
        *({**RECORD, "number": wrong} for wrong in (-1, True, 1.0, MAX_NUMBER + 1)),
        *({**RECORD, "values": wrong} for wrong in (None, [])),
        *({**RECORD, name: None} for name in ("time", "previous")),
        *({**RECORD, **wrong} for wrong in ({"sha256": 5}, {"kind": "plan "}, {"more": 1})),
        *({name: RECORD[name] for name in RECORD if name != absent} for absent in RECORD),
        dict(reversed(list(RECORD.items()))),
    ],
)
def test_what_is_no_record_is_none(values):
    assert record_of_line(line_of(RECORD)) is not None
    assert record_of_line(line_of(values)) is None


def test_a_record_of_a_kind_of_a_later_version_is_kept_and_changes_nothing(tmp_path):
    log = write_log(tmp_path)
    before = log.description
    values = [log.last.number + 1, NOW, "later", {"x": 1}, log.last.sha256]
    covered = json.dumps(values, separators=(",", ":")).encode()
    later = log.add(LogRecord(*values, hashlib.sha256(covered).hexdigest()))
    found = read_log(tmp_path)
    assert found.is_whole and found.records[-1] == later
    assert description_of(found.records) == before


def test_both_files_have_the_same_lines_and_survey_json_shows_what_they_say(tmp_path):
    log = make_survey(tmp_path / "survey")
    whole = b"".join(one.line() for one in log.records)
    assert both_files(tmp_path / "survey") == dict.fromkeys(FILES, whole)
    assert json.loads((tmp_path / "survey" / "survey.json").read_text()) == log.description
    assert description_of(log.records) == log.description


def test_a_log_that_is_full_takes_what_a_survey_needs_and_stays_readable(tmp_path, monkeypatch):
    log = write_log(tmp_path)
    monkeypatch.setattr(survey_log, "MAX_LOG_BYTES", 40_000)
    with raises_fault("value.not_allowed", 40_000, error=SurveyRefusedError):
        for _ in range(1000):
            log.add(log.next(Kind.PAUSE, {"reason": "x" * 4000}, NOW))
    assert read_log(tmp_path).is_whole and read_log(tmp_path).records == log.records
    for kind in (Kind.END, Kind.BAG, Kind.RESUME, Kind.END) * 20:
        log.add(log.next(kind, {"reason": "x" * 4000}, NOW))
    assert read_log(tmp_path).is_whole and read_log(tmp_path).records == log.records


@pytest.mark.parametrize("name", FILES)
def test_a_log_that_is_too_large_to_be_read_is_named_and_not_missing(tmp_path, monkeypatch, name):
    write_log(tmp_path)
    monkeypatch.setattr(survey_log, "READ_BYTES", 2 * (tmp_path / name).stat().st_size)
    (tmp_path / name).write_bytes(3 * (tmp_path / name).read_bytes())
    with raises_fault("value.not_allowed", tmp_path / name, error=SurveyRefusedError):
        recover(tmp_path)


@pytest.fixture
def folder(tmp_path):
    make_survey(tmp_path / "survey")
    return tmp_path / "survey"


def test_the_manifest_names_the_log_by_its_last_record_and_is_read_as_it_was_written(folder):
    sealed, records = manifest.read_manifest(folder), recover(folder).found.records
    assert sealed.log == LogHead.of(records[-1]) and sealed.covers(records)
    assert set(sealed.files) == {"survey.json", "traces/one.json"}
    assert manifest.decode(sealed.encode()) == sealed
    before = (folder / "manifest.json").read_bytes()
    add_to_survey(folder, add_marker(7), NOW)
    after = recover(folder).found.records
    assert (folder / "manifest.json").read_bytes() == before
    assert sealed.covers(after) and list(sealed.since(after)) == [after[-1]]
    assert sealed.is_binding(after) and not sealed.covers(records[:-1])


def test_every_bit_of_a_manifest_is_covered(folder):
    whole, chance = (folder / "manifest.json").read_bytes(), random.Random(SEED)
    for _ in range(draws(50)):
        for damaged in (flipped(chance, whole), whole[: chance.randrange(len(whole))]):
            with pytest.raises(manifest.ManifestDamagedError):
                manifest.decode(damaged)


@each_case("key", ["files", "survey_id", "log", "format"])
@each_case("value", [1, [1], "x", {"number": -1, "sha256": "a"}, {"number": 1, "sha256": 1}])
def test_a_manifest_with_entries_of_another_type_is_damaged(folder, key, value):
    values = json.loads((folder / "manifest.json").read_text())
    if type(value) is type(values[key]) and key == "survey_id":
        value = 2.5
    del values["sha256"]
    with pytest.raises(manifest.ManifestDamagedError):
        manifest.decode(with_own_sum({**values, key: value}))
