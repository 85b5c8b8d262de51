"""What may be requested in which state; the rest is refused, says what to do, and has no effect."""

from dataclasses import replace

import pytest
from fake_robot import LIMIT_S
from survey_examples import PARAMETERS

from gpr20_common.faults import ASKED_FOR
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.mid.survey.survey_status import TRANSITIONS, SurveyStatus
from gpr20_survey.plan.survey_state import RUNNING
from gpr20_survey.plan.survey_state import SurveyState as State

VNA = "vna_acquisition"


def hold(bench):
    """Let the sweep after three traces wait."""
    bench.at_sweep(3, lambda: bench.go_on.wait(LIMIT_S))


def fail(bench):
    bench.analyzer.calibration_refusal = "there is no calibration"


def close_slowly(bench):
    close = bench.storage.close
    bench.storage.close = lambda *given: (bench.go_on.wait(LIMIT_S), close(*given))
    bench.at_sweep(3, bench.control.stop)


# Of each state: what brings a survey there, once it is started, if it is.
WAYS = {
    State.IDLE: None,
    State.CONFIGURED: None,
    State.CHECKING: lambda bench: bench.at_sweep(3, lambda: bench.nodes.note_silent(VNA)),
    State.HOMING: lambda bench: bench.y.hanging.clear(),
    State.SURVEYING: hold,
    State.PAUSING: hold,
    State.PAUSED: lambda bench: setattr(bench.y, "fail_move", "the endstop was pressed"),
    State.STOPPING: close_slowly,
    State.STOPPED: lambda bench: bench.at_sweep(3, bench.control.stop),
    State.FAILED: fail,
    State.FINISHED: lambda bench: None,
}


def bring(bench, state):
    """Bring the control into a state, in which it stays."""
    if state is not State.IDLE:
        bench.control.set_parameters(PARAMETERS)
    if WAYS[state] is not None:
        WAYS[state](bench)
        bench.control.start()
    if state in (State.SURVEYING, State.PAUSING):
        bench.wait_for_visited(3)
    if state is State.PAUSING:
        bench.control.pause()
    if state is State.CHECKING:
        bench.wait_until(lambda: bench.states[-2:] == ["SURVEYING", "CHECKING"])
    bench.wait_for(state)


@pytest.mark.parametrize("state", list(State))
def test_what_does_not_fit_the_state_is_refused_with_what_to_do_and_has_no_effect(bench, state):
    bring(bench, state)
    control, running = bench.control, state in RUNNING
    refused = {
        lambda: control.set_parameters(PARAMETERS): running,
        control.start: running or state is State.IDLE,
        control.pause: state is not State.SURVEYING,
        control.stop: not running,
        lambda: control.resume(""): state is not State.PAUSED,
        lambda: control.resume("20200101T000000_01234567"): True,
    }
    before = replace(bench.board.status, waiting=None)
    for request, is_refused in refused.items():
        if is_refused:
            with pytest.raises((RequestRefusedError, DeviceError)) as refusal:
                request()
            assert refusal.value.message.cause.remedy is not None
            # Nobody who asks for rest is told that nothing is to be done while something may move.
            nothing = refusal.value.message.fault_code == ASKED_FOR.code
            assert not (nothing and running)
            assert replace(bench.board.status, waiting=None) == before
    bench.release()
    bench.nodes.note_alive(VNA, 2)
    bench.y.fail_move = ""
    if state in (State.PAUSING, State.PAUSED):
        bench.wait_for(State.PAUSED)
        control.resume("")
    if running and state is not State.STOPPING:
        bench.complete()
    states = [State.IDLE, *(status.state for status in bench.history)]
    assert all(a is b or b in TRANSITIONS[a] for a, b in zip(states, states[1:]))


def test_a_state_that_cannot_follow_is_refused_and_changes_nothing():
    status = SurveyStatus(lambda *_changed: None, lambda _parameters: None, lambda *_known: None)
    for state in set(State) - TRANSITIONS[State.IDLE]:
        with pytest.raises(RequestRefusedError):
            status.enter(state, Message("late"))
        assert status.status.state is State.IDLE


# Of two clients none starts the plan of the other.

OTHER = replace(PARAMETERS, y_points=3)


def test_how_a_survey_ended_stays_until_the_next_start_whatever_is_planned(bench):
    survey_id = bench.start()
    bench.complete()
    ended = bench.board.status
    assert (ended.end, ended.ended_us) == (State.FINISHED, bench.storage.ends[-1].status.ended_us)
    for _request in range(3):
        bench.control.set_parameters(OTHER, "/flood")
    shown = bench.board.status
    assert shown.state is State.CONFIGURED
    assert (shown.survey_id, shown.end, shown.ended_us) == (survey_id, ended.end, ended.ended_us)
    bench.control.start()
    assert bench.board.status.end is State.IDLE
    bench.control.stop()
    assert bench.wait_for(State.STOPPED).end is State.STOPPED
