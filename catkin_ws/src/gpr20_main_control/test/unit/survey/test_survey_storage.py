"""Storing in the background, and its records: disk, metadata, coverage."""

import json
import threading
from dataclasses import replace

import pytest
from fake_robot import LIMIT_S, PARAMETERS, Bench, reports
from fault_kit import raises_fault

from gpr20_common.faults import INTERNAL, NOT_ALLOWED
from gpr20_main_control.mid.survey import sampling
from gpr20_main_control.mid.survey.survey_archive import ATTEMPTS, StorageQueue
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.faults import CAN_RESUME, TAKES_LONG
from gpr20_survey.folder.log_record import PLANNED_PERMITTIVITY
from gpr20_survey.plan.annotation import EMPTY, Annotation, Wgs84Position, annotation_of
from gpr20_survey.plan.recorded_plan import refines_of
from gpr20_survey.plan.survey_state import SurveyState as State

OWN = Annotation("Ana", "here", "wet", Wgs84Position(4.6, -74.1))
ROBOTS = Annotation("Eva", "there", position=Wgs84Position(4.6, -74.1))
COARSE = "7c9e6679-7425-40de-944b-e07fc1f90ae7"


def metadata_of_two(bench, *arguments):
    """Survey with what is started with, and then without it; return the metadata of both."""
    bench.control.set_parameters(PARAMETERS)
    for given in (arguments, ()):
        bench.control.start(*given)
        bench.wait_for(State.FINISHED)
    return [json.loads(one.metadata_json) for one in bench.storage.records]


def test_the_metadata_say_what_was_measured_with_what_and_what_is_of_this_survey_alone(bench):
    first, second = metadata_of_two(bench, OWN, COARSE, 4.5)
    assert bench.storage.records[0].needed_bytes > 24 * 5 * 100
    assert first["simulated"] is True and first["parameters"]["x_points"] == 3
    assert first["instrument"]["identity"] == bench.analyzer.identity
    assert first["axes"]["x"]["max_coord"] == 650.0
    assert (annotation_of(first), refines_of(first), first[PLANNED_PERMITTIVITY]) == (
        OWN,
        COARSE,
        4.5,
    )
    assert (annotation_of(second), refines_of(second)) == (EMPTY, "")
    assert PLANNED_PERMITTIVITY not in second and "refines" not in second


def test_what_a_survey_is_started_without_is_that_of_the_robot():
    first, second = metadata_of_two(Bench(defaults=ROBOTS), Annotation(site="here", notes="wet"))
    assert annotation_of(first) == replace(ROBOTS, site="here", notes="wet")
    assert annotation_of(second) == ROBOTS


@pytest.mark.parametrize("wrong", ["../x", COARSE.upper(), COARSE + " "])
def test_a_survey_refines_none_that_is_not_an_id(bench, wrong):
    bench.control.set_parameters(PARAMETERS)
    with raises_fault(NOT_ALLOWED, repr(wrong), error=SurveyRefusedError):
        bench.control.start(refines=wrong)


def break_down(*_arguments):
    raise ValueError("a fault of ours")


def test_a_slow_disk_makes_the_survey_wait_and_say_so(bench):
    bench.storage.free.clear()
    bench.start()
    # One trace is being stored and four wait; a sixth would have no room.
    bench.wait_until(lambda: reports(bench.board.status.full_message, TAKES_LONG))
    assert (bench.analyzer.sweeps, bench.board.status.visited_points) == (5, 0)
    bench.storage.free.set()
    bench.complete()


def test_a_folder_that_holds_too_few_traces_is_never_called_finished(bench):
    bench.storage.lose = 1
    bench.start()
    final = bench.wait_for(State.FAILED, State.FINISHED)
    assert final.state is State.FAILED
    assert reports(final.message, CAN_RESUME, 23, 24)
    assert bench.storage.ends[-1].reason.fault_code == CAN_RESUME.code
    assert bench.storage.ends[-1].outcome == "failed"
    assert bench.storage.ends[-1].status == final


def test_a_trace_that_is_refused_pauses_the_survey(bench, monkeypatch):
    monkeypatch.setattr(sampling, "time_of_day_us", lambda: 1)
    bench.start()
    status = bench.wait_for(State.PAUSED, State.FAILED)
    assert status.state is State.PAUSED and "1970-01-01" in str(status.message)
    monkeypatch.undo()
    bench.resume_to_the_end()


def test_a_fault_in_closing_does_not_leave_the_survey_stopping_for_ever(bench):
    bench.storage.close = break_down
    bench.at_sweep(3, bench.control.stop)
    bench.start()
    message = bench.wait_for(State.STOPPED).message
    assert CAN_RESUME in message.faults and message.fault_code == INTERNAL.code


def test_a_shutdown_closes_a_paused_survey_that_is_complete(bench):
    bench.storage.fail_close = "the disk is slow"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.storage.fail_close = ""
    bench.control.shut_down(LIMIT_S)
    assert bench.states[-3:] == ["PAUSED", "STOPPING", "FINISHED"]
    assert [one.outcome for one in bench.storage.ends] == ["finished"]


def test_a_failure_that_began_before_a_retry_does_not_count(bench):
    bench.start()
    bench.complete()
    (trace, *_), storing, refuse = bench.storage.samples, threading.Event(), threading.Event()
    attempts = []

    class Slow:
        """Refuses, late, all attempts that began before the retry."""

        def store(self, stored):
            attempts.append(stored)
            if len(attempts) <= ATTEMPTS:
                storing.set()
                refuse.wait(LIMIT_S)
                raise ConnectionError("no survey is open")

    queue = StorageQueue(Slow(), bench.clock, lambda _index: None)
    queue.add(trace)
    assert storing.wait(LIMIT_S)
    queue.retry()
    refuse.set()
    queue.wait_until_left(0, lambda: None)
    queue.close()
    assert attempts == [trace] * (ATTEMPTS + 1)
