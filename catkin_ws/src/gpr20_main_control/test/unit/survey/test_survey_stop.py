"""Ends that are not the plan's: a stop, a shut down, a fault of the software itself."""

import threading

import pytest
from cut_off_surveys import reopened_survey
from fake_robot import LIMIT_S, NODES, reports
from fault_kit import raises_fault
from survey_examples import PARAMETERS

from gpr20_main_control import faults
from gpr20_main_control.errors import RequestRefusedError
from gpr20_survey.plan.survey_state import SurveyState as State


def test_a_stop_during_a_move_ends_as_stopped_with_what_was_measured(bench):
    def block():
        if bench.analyzer.sweeps == 2:
            for axis in bench.axes:
                axis.blocked.clear()

    bench.analyzer.on_sweep = block
    bench.start()
    bench.wait_for_visited(2)
    assert str(bench.control.stop()).startswith("Stopping")
    for axis in bench.axes:
        assert axis.stops > 0
        axis.blocked.set()
    final = bench.wait_for(State.STOPPED)
    assert bench.states[-2:] == ["STOPPING", "STOPPED"]
    assert faults.STOPPED_ON_REQUEST in final.message.faults
    assert final.target is None
    assert len(bench.storage.samples) < 24
    assert bench.storage.closed[-1][1] == "stopped"
    assert bench.storage.ends[-1].status == final


def test_a_fault_in_the_survey_itself_stops_the_axes_and_is_told(bench, monkeypatch, fault_log):
    ended = []
    monkeypatch.setattr(threading, "excepthook", ended.append)

    def break_down():
        raise ZeroDivisionError("a fault of ours")

    bench.analyzer.on_sweep = break_down
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "a fault of ours" in str(final.message)
    assert all(axis.stops > 0 for axis in bench.axes)
    assert bench.storage.closed[-1][1] == "failed"
    assert bench.storage.ends[-1].status == final
    # The thread ends as after any other survey: its node goes on.
    bench.control.shut_down(LIMIT_S)
    assert ended == []
    assert "Traceback" in "".join(fault_log)


def test_shutting_down_stops_the_axes_and_leaves_the_survey_interrupted(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    threading.Timer(0.05, bench.x.blocked.set).start()
    bench.control.shut_down(LIMIT_S)
    assert all(axis.stops > 0 for axis in bench.axes)
    assert bench.board.status.state is State.STOPPED
    assert [outcome for _survey, outcome, _reason in bench.storage.closed] == ["interrupted"]
    assert bench.board.status.message.fault_code == faults.ROBOT_SHUT_DOWN.code


def test_shutting_down_while_a_survey_is_closed_says_finished(bench):
    closing, may_close = threading.Event(), threading.Event()
    close = bench.storage.close

    def close_slowly(survey_id, end):
        closing.set()
        may_close.wait(LIMIT_S)
        close(survey_id, end)

    bench.storage.close = close_slowly
    bench.start()
    assert closing.wait(LIMIT_S)
    threading.Timer(0.05, may_close.set).start()
    bench.control.shut_down(LIMIT_S)
    assert bench.board.status.state is State.FINISHED
    assert {outcome for _survey, outcome, _reason in bench.storage.closed} == {"finished"}


def test_shutting_down_does_not_wait_for_a_storage_that_is_gone(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.storage.fail_close = "the storage has ended"
    bench.x.blocked.set()
    bench.control.shut_down(LIMIT_S)
    assert bench.board.status.state is State.STOPPED


def test_a_stop_does_not_wait_for_an_instrument_that_hangs(bench):
    swept, hang = threading.Event(), threading.Event()

    def hang_up():
        swept.set()
        hang.wait(LIMIT_S)

    bench.analyzer.on_sweep = hang_up
    bench.start()
    assert swept.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    assert not hang.is_set()
    hang.set()
    assert bench.storage.samples == []


def test_a_stop_does_not_wait_for_an_axis_that_hangs_in_its_homing(bench):
    bench.y.hanging.clear()
    bench.start()
    bench.wait_for(State.HOMING)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    bench.y.hanging.set()


def test_stopped_is_said_only_when_no_axis_moves_any_more(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPING)
    at_rest = []
    threading.Timer(0.005, lambda: (at_rest.append(True), bench.x.blocked.set())).start()
    bench.wait_for(State.STOPPED)
    assert at_rest or bench.board.status.message.may_move


def test_an_axis_that_does_not_stop_is_told(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.stop()
    final = bench.wait_for(State.STOPPED)
    assert final.message.fault_code == faults.AXIS_STILL_MOVING.code
    assert final.message.may_move


def test_an_axis_that_is_silent_at_a_stop_is_said_to_move(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.x.silent = True
    bench.control.stop()
    final = bench.wait_for(State.STOPPED)
    assert reports(final.message, faults.AXIS_STILL_MOVING, "x")
    assert final.message.may_move


def test_an_axis_that_never_moved_is_not_said_to_move(bench):
    bench.z.silent = True
    bench.start()
    assert not bench.wait_for(State.FAILED).message.may_move


def test_a_stop_does_not_wait_for_an_instrument_that_hangs_in_the_checks(bench, monkeypatch):
    asked, answer = threading.Event(), threading.Event()

    def hang_up(_address):
        asked.set()
        assert answer.wait(LIMIT_S)
        return "too late"

    monkeypatch.setattr(bench.analyzer, "connect", hang_up)
    bench.start()
    assert asked.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    assert not answer.is_set()
    answer.set()


def test_a_stop_does_not_wait_for_a_storage_that_hangs_and_does_not_come_back(bench, monkeypatch):
    hang = threading.Event()
    monkeypatch.setattr(bench.storage, "close", lambda *_: hang.wait(LIMIT_S))
    bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 3 and bench.control.stop()
    bench.start()
    bench.wait_for(State.STOPPING)
    bench.nodes.note_silent("vna_processing")
    status = bench.wait_for(State.STOPPED)
    assert faults.NOT_FINISHED in status.message.faults
    assert NODES["vna_processing"] in [
        value for one in status.message.nested() for value in one.values.values()
    ]
    hang.set()


def test_a_survey_can_follow_one_that_was_stopped(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    bench.y.fail_move = ""
    bench.start()
    bench.wait_for(State.FINISHED)


def test_a_stop_after_the_parameters_were_set_keeps_the_survey_from_starting(bench):
    bench.control.set_parameters(PARAMETERS)
    with raises_fault(faults.NONE_RUNNING, error=RequestRefusedError):
        bench.control.stop()
    with raises_fault(faults.STOPPED_BEFORE, error=RequestRefusedError):
        bench.control.start()
    assert not any(axis.moves for axis in bench.axes)
    bench.start()
    bench.complete()


@pytest.mark.parametrize("request_of", ["set_parameters", "start", "resume"])
def test_what_is_being_prepared_when_stop_comes_does_not_begin(bench, monkeypatch, request_of):
    bench.storage.reopened = reopened_survey([0, 1])
    bench.control.set_parameters(PARAMETERS)
    description, taken = bench.control._robot.description, []

    def slowly(*arguments):
        taken.append(str(bench.control.stop()))
        return config(*arguments)

    config = description.config
    monkeypatch.setattr(description, "config", slowly)
    requests = {
        "set_parameters": bench.start,
        "start": bench.control.start,
        "resume": lambda: bench.control.resume("survey"),
    }
    with raises_fault(faults.STOPPED_BEFORE, error=RequestRefusedError):
        requests[request_of]()
    assert "does not begin" in taken[0]
    assert not any(axis.moves or axis.homings for axis in bench.axes)
    assert not bench.board.status.state.running


def test_a_survey_can_be_started_again_after_its_stop(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.stop()
    bench.x.blocked.set()
    bench.wait_for(State.STOPPED)
    bench.control.start()
    bench.complete()
