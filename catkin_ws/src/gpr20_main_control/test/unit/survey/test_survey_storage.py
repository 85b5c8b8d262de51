"""Storing in the background, and its records: disk, metadata, coverage."""

import json
import re
import threading

import pytest
from fake_robot import LIMIT_S, PARAMETERS, Bench, FakeStorage, reports
from fault_kit import raises_fault

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import INTERNAL
from gpr20_common.low.clock import Clock
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.survey import sampling, survey_ending
from gpr20_main_control.mid.survey.storage_queue import StorageQueue
from gpr20_survey.folder.soil_note import PLANNED
from gpr20_survey.plan.annotation import EMPTY, Annotation, Wgs84Position, annotation_of
from gpr20_survey.plan.coverage import SampleState
from gpr20_survey.plan.refines import refines_of
from gpr20_survey.plan.survey_state import SurveyState as State


def test_the_metadata_say_what_was_measured_with_what(bench):
    survey_id = bench.start()
    bench.wait_for(State.FINISHED)
    record = bench.storage.records[0]
    metadata = json.loads(record.metadata_json)
    assert record.survey_id == survey_id
    assert metadata["simulated"] is True
    assert metadata["parameters"]["x_points"] == 3
    assert metadata["instrument"]["identity"] == "Anritsu,MS2026C/2,SIMULATED,1.0"
    assert metadata["axes"]["x"]["max_coord"] == 650.0
    assert record.needed_bytes > 24 * 5 * 100


def annotated(bench, survey_id):
    records = {one.survey_id: json.loads(one.metadata_json) for one in bench.storage.records}
    return annotation_of(records[survey_id])


def test_a_survey_has_the_annotation_it_was_started_with_and_the_next_one_has_none():
    bench = Bench()
    bench.control.set_parameters(PARAMETERS)
    own = Annotation("Ana", "here", "wet", Wgs84Position(4.6, -74.1))
    first = bench.control.start(own)
    bench.wait_for(State.FINISHED)
    second = bench.control.start()
    bench.wait_for(State.FINISHED)
    assert annotated(bench, first) == own
    assert annotated(bench, second) == EMPTY


def test_what_a_survey_is_started_without_is_that_of_the_robot():
    bench = Bench(defaults=Annotation("Ana", "here", position=Wgs84Position(4.6, -74.1)))
    bench.control.set_parameters(PARAMETERS)
    survey_id = bench.control.start(Annotation(site="there", notes="wet"))
    bench.wait_for(State.FINISHED)
    assert annotated(bench, survey_id) == Annotation(
        "Ana", "there", "wet", Wgs84Position(4.6, -74.1)
    )


def test_a_survey_has_the_permittivity_of_its_plan_if_that_is_known():
    bench = Bench()
    bench.control.set_parameters(PARAMETERS)
    for permittivity in (4.5, None):
        bench.control.start(permittivity=permittivity)
        bench.wait_for(State.FINISHED)
    known, unknown = (json.loads(one.metadata_json) for one in bench.storage.records)
    assert known[PLANNED] == 4.5
    assert PLANNED not in unknown


def test_a_finer_survey_says_which_one_it_refines_and_others_say_nothing():
    bench = Bench()
    bench.control.set_parameters(PARAMETERS)
    coarse = "7c9e6679-7425-40de-944b-e07fc1f90ae7"
    for wrong in ("x", "../x", coarse.upper(), coarse + " "):
        with pytest.raises(InvalidValueError, match=re.escape(repr(wrong))):
            bench.control.start(refines=wrong)
    bench.control.start(refines=coarse)
    bench.wait_for(State.FINISHED)
    bench.control.start()
    bench.wait_for(State.FINISHED)
    records = [json.loads(one.metadata_json) for one in bench.storage.records]
    assert records[0]["refines"] == coarse
    assert "refines" not in records[1]
    assert [refines_of(one) for one in records] == [coarse, ""]


def test_a_full_disk_at_the_start_is_refused_before_anything_moves(bench):
    bench.storage.fail_open = "0 bytes are free"
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "0 bytes are free" in str(final.message)
    assert [axis.homings for axis in bench.axes] == [0, 0, 0]


def test_a_failing_disk_pauses_the_survey_and_loses_nothing(bench):
    bench.storage.failures = 3
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert faults.NOT_STORED in status.message.faults
    assert "the disk is full" in str(status.message)
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    # The storage may have been restarted: the survey is reopened, not opened a second time.
    assert len(bench.storage.records) == 1
    assert bench.storage.reopenings == ["survey"]
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_fault_in_storing_pauses_the_survey_and_loses_nothing(bench, monkeypatch):
    def break_down(_sample):
        raise ValueError("a fault of ours")

    monkeypatch.setattr(bench.storage, "store", break_down)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert faults.NOT_STORED in status.message.faults
    assert status.message.fault_code == INTERNAL.code
    assert "a fault of ours" in str(status.message)
    monkeypatch.undo()
    bench.resume_to_the_end()


def test_a_slow_disk_makes_the_survey_wait(bench):
    bench.storage.free.clear()
    fifth, sixth = threading.Event(), threading.Event()

    def note():
        # Called at the beginning of a sweep, before it is counted.
        {4: fifth, 5: sixth}.get(bench.analyzer.sweeps, threading.Event()).set()

    bench.analyzer.on_sweep = note
    bench.start()
    # One trace is being stored and four wait; a sixth would have no room.
    assert fifth.wait(LIMIT_S)
    assert not sixth.wait(0.5)
    assert bench.board.status.visited_points == 0
    bench.storage.free.set()
    bench.complete()


def test_a_folder_that_holds_too_few_traces_is_never_called_finished(bench):
    bench.storage.lose = 1
    bench.start()
    final = bench.wait_for(State.FAILED, State.FINISHED)
    assert final.state is State.FAILED
    assert reports(final.message, faults.INCOMPLETE, 23, 24)
    assert bench.storage.closed[-1][1] == "failed"
    assert bench.storage.ends[-1].status == final


def test_the_coverage_says_of_every_sample_what_became_of_it(bench):
    def break_down():
        if bench.analyzer.sweeps == 4:
            bench.analyzer.failures = 1

    bench.analyzer.on_sweep = break_down
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.wait_for_visited(4)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    report = bench.storage.reports[-1]
    assert report["coverage"] == "mmmmf" + 19 * "-"
    (failed,) = report["failed"]
    assert (failed["index"], failed["reason"]) == (4, "the VNA did not answer")
    assert report["verdict"].startswith("INCOMPLETE: 4 of 24 planned traces are stored, 1 failed")
    assert bench.coverages[-1][0].count(SampleState.MEASURED) == 4


def test_a_finished_survey_is_complete_and_only_then_that_word_appears(bench):
    bench.start()
    status = bench.wait_for(State.FINISHED)
    assert "complete: all 24 planned traces are stored" in str(status.message)
    assert bench.storage.reports[-1]["coverage"] == 24 * "m"
    early = [verdict for _states, verdict in bench.coverages[:-1]]
    assert early and not any(verdict.complete for verdict in early)
    assert all("complete:" not in str(verdict.message) for verdict in early)


def test_a_trace_that_is_refused_pauses_the_survey(bench, monkeypatch):
    monkeypatch.setattr(sampling, "time_of_day_us", lambda: 1)
    bench.start()
    status = bench.wait_for(State.PAUSED, State.FAILED)
    assert status.state is State.PAUSED and "1970-01-01" in str(status.message)
    monkeypatch.undo()
    bench.resume_to_the_end()


def test_a_fault_in_closing_does_not_leave_the_survey_stopping_for_ever(bench, monkeypatch):
    def break_down(*_arguments):
        raise ValueError("a fault of ours")

    bench.analyzer.failures = 1
    bench.start()
    bench.wait_for(State.PAUSED)
    monkeypatch.setattr(bench.storage, "close", break_down)
    bench.control.stop()
    message = bench.wait_for(State.STOPPED).message
    assert faults.NOT_FINISHED in message.faults
    assert message.fault_code == INTERNAL.code


def test_a_trace_that_is_stored_after_its_survey_ended_does_not_count_for_the_next(
    bench, monkeypatch
):
    monkeypatch.setattr(survey_ending, "STOPPING_LIMIT_S", 0.1)
    begun, go_on, stored = threading.Event(), threading.Event(), threading.Event()

    def store_late(_trace):
        begun.set()
        go_on.wait(LIMIT_S)
        stored.set()

    monkeypatch.setattr(bench.storage, "store", store_late)
    bench.start()
    assert begun.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    monkeypatch.undo()
    bench.storage.free.clear()
    bench.control.start()
    bench.wait_for(State.SURVEYING)
    go_on.set()
    assert stored.wait(LIMIT_S)
    with pytest.raises(AssertionError):
        bench.wait_for_visited(1, limit_s=0.3)


def test_a_trace_that_is_stored_at_the_last_moment_is_not_called_missing(bench):
    storage = FakeStorage()
    storage.free.clear()
    queue = StorageQueue(storage, Clock(), lambda _stored, _index: None)
    bench.start()
    bench.wait_for(State.FINISHED)
    queue.add(bench.storage.samples[0])
    threading.Timer(0.06, storage.free.set).start()
    # It waits 0.1 s at a time.
    queue.drain_within(0.03)
    queue.close()
    storage.free.clear()
    queue = StorageQueue(storage, Clock(), lambda _stored, _index: None)
    queue.add(bench.storage.samples[0])
    with raises_fault(faults.NOT_STORED, 1, 0.03, error=DeviceError):
        queue.drain_within(0.03)
    queue.close()
    storage.free.set()


def test_a_trace_whose_storing_cannot_be_shown_is_not_stored_again(bench, fault_log):
    bench.start()
    bench.wait_for(State.FINISHED)
    storage, traces = FakeStorage(), bench.storage.samples[:2]

    def fail(_stored, _index):
        raise ZeroDivisionError("a fault of ours")

    queue = StorageQueue(storage, Clock(), fail)
    for trace in traces:
        queue.add(trace)
    queue.drain_within(LIMIT_S)
    queue.close()
    assert storage.samples == traces
    assert len(fault_log) == 2
