"""What verify says where a survey's entries, nodes and clocks contradict each other."""

from __future__ import annotations

import pytest
from survey_kit import NOW_NS, STARTED_US, describe_again, make_survey

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import DAMAGED
from gpr20_survey.trace import utc_time

SIMULATED = {"identity": "Anritsu,MS2026C/2,SIMULATED,1.0"}
REAL = {"identity": "Anritsu,MS2026C/2,7654321,1.23"}
S = 10**6  # [us]


def node(name, simulated):
    return {"name": name, "simulated": simulated, "hardware": "pins"}


MEASURED_BY = (
    ({"simulated": True, "instrument": SIMULATED}, []),
    ({"simulated": False, "instrument": REAL}, []),
    ({"simulated": False, "instrument": {}}, []),
    ({"simulated": False, "instrument": REAL, "nodes": [node("/x", False)]}, []),
    (
        {"simulated": False, "instrument": SIMULATED},
        ["survey.json says simulated: false, but the analyzer's identity is "
         "Anritsu,MS2026C/2,SIMULATED,1.0"],
    ),
    (
        {"simulated": True, "instrument": REAL},
        ["survey.json says simulated: true, but the analyzer's identity is "
         "Anritsu,MS2026C/2,7654321,1.23"],
    ),
    (
        {"simulated": False, "nodes": [node("/x", False), node("/vna", True)]},
        ["survey.json says simulated: false, but for node /vna it says true"],
    ),
    (
        {"simulated": True, "nodes": [node("/x", False)]},
        ["survey.json says simulated: true, but for node /x it says false"],
    ),
    (
        {"simulated": True, "nodes": [{"name": "/x"}]},
        ["survey.json says simulated: true, but for node /x it says None"],
    ),
    (
        {"simulated": True, "nodes": 7},
        ["survey.json says simulated: true, but for node 7 it says None"],
    ),
)  # fmt: skip


def test_simulated_agrees_with_what_measured_the_survey(tmp_path):
    for number, (more, faults) in enumerate(MEASURED_BY):
        folder = make_survey(tmp_path / str(number), 4, "stopped", more=more)
        assert [str(one) for one in verify_survey(folder).faults] == faults, more


def notes(folder):
    found = verify_survey(folder)
    assert found.faults == []
    return [str(one) for one in found.notes]


def at(time_us, sweep_us=None):
    sweep_us = time_us - 1000 if sweep_us is None else sweep_us
    return {
        "timestamp_us": time_us,
        "sweep_started_us": sweep_us,
        "sweep_ended_us": max(sweep_us, time_us - 500),
    }


def test_traces_in_order_of_time_need_no_note(tmp_path):
    assert notes(make_survey(tmp_path, 4, "stopped")) == []


def test_a_clock_that_was_set_back_between_two_traces_is_told_with_both_times(tmp_path):
    back = {2: at(STARTED_US + 2 * S), 3: at(STARTED_US + 5 * S)}
    (note,) = notes(make_survey(tmp_path, 4, "stopped", misplaced=back))
    assert note.startswith("out of order: trace 2 of 2026-09-21T14:13:22.123456+00:00 was recorded")
    assert "after trace 1 of 2026-09-21T14:13:23.123456+00:00" in note


def test_traces_outside_of_the_survey_are_told(tmp_path):
    ended_us = NOW_NS // 1000
    outside = {0: at(STARTED_US - S), 3: at(ended_us + S)}
    older, newer = notes(make_survey(tmp_path, 4, "stopped", misplaced=outside))
    assert older.startswith("1 traces are older than the start of the survey")
    assert older.endswith(": 0")
    assert newer.startswith("1 traces are newer than the end of the survey")
    assert newer.endswith(": 3")


def test_a_trace_older_than_its_sweep_is_told(tmp_path):
    odd = {1: at(STARTED_US + 3 * S, STARTED_US + 4 * S)}
    (note,) = notes(make_survey(tmp_path, 4, "stopped", misplaced=odd))
    assert "trace 1 of 2026-09-21T14:13:23.123456+00:00 has a sweep that started at" in note


def test_an_end_before_the_start_is_told(tmp_path):
    folder = make_survey(tmp_path, 4, None)
    ended = utc_time.iso_text(STARTED_US - S)
    describe_again(folder, ended=ended)
    (folder / "survey.mcap").unlink()  # which holds the log as it was
    found = verify_survey(folder)
    assert found.status == DAMAGED
    assert any(f"the survey ended at {ended}, before it started" in str(one) for one in found.notes)


def test_many_traces_out_of_order_are_counted(tmp_path):
    back = {index: at(STARTED_US + (50 - index) * S) for index in range(9)}
    *named, rest = notes(make_survey(tmp_path, 9, "stopped", misplaced=back))
    assert len(named) == 5
    assert rest == "3 more are out of order"


@pytest.mark.parametrize(
    ("name", "noted"), [("20260921T141320_7c9e6679", 1), ("copy of the survey", 0)]
)
def test_a_folder_with_the_name_of_another_survey_is_noted(tmp_path, name, noted):
    folder = make_survey(tmp_path, 4, "stopped")
    found = notes(folder.rename(folder.parent / name))
    assert len([one for one in found if f"the name {name} of another survey" in one]) == noted
