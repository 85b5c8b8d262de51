"""Ends that are not the plan's: a stop, a shut down, a fault of the software itself."""

import threading

import pytest
from cut_off_surveys import reopened_survey
from fake_robot import LIMIT_S, reports
from fault_kit import raises_fault
from survey_examples import PARAMETERS

from gpr20_common.faults import ASKED_FOR, MAY_MOVE
from gpr20_main_control.errors import STOPPED_BEFORE, RequestRefusedError
from gpr20_survey.faults import STOPPED
from gpr20_survey.plan.survey_state import SurveyState as State


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
    assert bench.storage.ends[-1].outcome == "failed"
    assert bench.storage.ends[-1].status == final
    # The thread ends as after any other survey: its node goes on.
    bench.control.shut_down(LIMIT_S)
    assert ended == []
    assert "Traceback" in "".join(fault_log)


def test_shutting_down_stops_the_axes_and_leaves_the_survey_interrupted(bench):
    bench.x.blocked.clear()
    stop = bench.x.stop
    bench.x.stop = lambda: (stop(), bench.x.blocked.set())
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.shut_down(LIMIT_S)
    assert all(axis.stops > 0 for axis in bench.axes)
    assert bench.board.status.state is State.STOPPED
    assert [one.outcome for one in bench.storage.ends] == ["interrupted"]
    assert bench.board.status.message.fault_code == STOPPED.code


@pytest.mark.parametrize("silent, disk", [(False, ""), (True, ""), (False, "the disk is full")])
def test_an_axis_that_does_not_stop_or_is_silent_is_said_to_move_whatever_else_is_said(
    bench, silent, disk
):
    bench.x.blocked.clear()
    bench.storage.fail_close = disk
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.x.silent = silent
    bench.control.stop()
    message = bench.wait_for(State.STOPPED).message
    assert reports(message, MAY_MOVE, *"x" * silent) and message.may_move
    assert message.cause == MAY_MOVE
    assert STOPPED in message.faults


@pytest.mark.parametrize(
    "part, call", [("analyzer", "sweep"), ("storage", "store"), ("y", "home"), ("x", "")]
)
def test_a_stop_stops_every_axis_before_the_thread_of_the_survey_looks_again(bench, part, call):
    """It is held where it would see the stop: in a sweep, storing, in a homing, in a move."""
    called, held, look = threading.Event(), threading.Event(), bench.nodes.check

    def hang_up(*_arguments):
        called.set()
        assert bench.go_on.wait(LIMIT_S)

    def hold():
        if called.is_set() or (bench.x.begun.is_set() and not call):
            held.set()
            assert bench.go_on.wait(LIMIT_S)
        look()

    if call:
        setattr(getattr(bench, part), call, hang_up)
    bench.nodes.check = hold
    bench.start()
    assert held.wait(LIMIT_S)
    before = [axis.stops for axis in bench.axes]
    bench.control.stop()
    assert [axis.stops for axis in bench.axes] == [number + 1 for number in before]
    bench.go_on.set()
    bench.wait_for(State.STOPPED)


@pytest.mark.parametrize(
    "part, call",
    [("analyzer", "connect"), ("analyzer", "sweep"), ("height", "height_m"), ("y", "home")],
)
def test_a_stop_does_not_wait_for_a_part_that_hangs(bench, part, call):
    called, go_on = threading.Event(), threading.Event()

    def hang_up(*_arguments):
        called.set()
        assert go_on.wait(LIMIT_S)

    setattr(getattr(bench, part), call, hang_up)
    bench.start()
    assert called.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    assert not go_on.is_set()
    go_on.set()
    assert bench.storage.samples == []


def test_a_stop_after_the_parameters_were_set_keeps_the_survey_from_starting(bench):
    bench.control.set_parameters(PARAMETERS)
    with raises_fault(ASKED_FOR, error=RequestRefusedError):
        bench.control.stop()
    with raises_fault(STOPPED_BEFORE, error=RequestRefusedError):
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
        taken.append(bench.control.stop())
        return config(*arguments)

    config = description.config
    monkeypatch.setattr(description, "config", slowly)
    requests = {
        "set_parameters": bench.start,
        "start": bench.control.start,
        "resume": lambda: bench.control.resume("survey"),
    }
    with raises_fault(STOPPED_BEFORE, error=RequestRefusedError):
        requests[request_of]()
    assert taken
    assert not any(axis.moves or axis.homings for axis in bench.axes)
    assert not bench.board.status.state.running


def test_a_stop_in_the_moment_in_which_a_survey_begins_ends_it(bench, monkeypatch):
    begin = bench.board.begin_survey
    stop_first = lambda plan: (bench.control.stop(), begin(plan))  # noqa: E731
    monkeypatch.setattr(bench.board, "begin_survey", stop_first)
    bench.start()
    bench.wait_for(State.STOPPED)
    assert not any(axis.moves or axis.homings for axis in bench.axes)


@pytest.mark.parametrize("part, call", [("analyzer", "connect"), ("storage", "open")])
def test_a_call_that_was_given_up_ends_before_the_next_one_of_its_part_begins(bench, part, call):
    """Late, it would undo what the next survey has set up, or close that survey."""
    usual, made = getattr(getattr(bench, part), call), []
    hanging, go_on = threading.Event(), threading.Event()

    def hang_once(argument):
        made.append("begins")
        if not hanging.is_set():
            hanging.set()
            assert go_on.wait(LIMIT_S)
        answer = usual(argument)
        made.append("ends")
        return answer

    setattr(getattr(bench, part), call, hang_once)
    bench.start()
    assert hanging.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    survey_id = bench.control.start()
    # If the next call did not wait for the late one, it would be made by then.
    threading.Timer(0.3, go_on.set).start()
    bench.complete()
    assert made == ["begins", "ends"] * 2
    assert bench.storage.records[-1].survey_id == survey_id
