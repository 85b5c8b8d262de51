import queue

import pytest
from test_fault_messages import ASKED_PAUSE, FULL, LOST

from gpr20_common import remedies
from gpr20_common.message import Message, verbatim
from gpr20_operator.robot.events import (
    Accepted,
    Answer,
    ControlState,
    Progress,
    Request,
    StopRequested,
)
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.terminal.follower import (
    ExitStatus,
    Limits,
    Mode,
    OnPause,
    Outcome,
    SurveyFollower,
)
from gpr20_user_interface.terminal.session import (
    SIMULATED,
    SurveySession,
    first_step,
    outcome_lines,
)


class ScriptedEvents:
    """Gives the events of a list; None lets time pass."""

    def __init__(self, clock, events):
        self._clock = clock
        self._events = list(events)

    def get(self, timeout):
        event = self._events.pop(0) if self._events else None
        if event is None:
            self._clock.advance(timeout)
            raise queue.Empty
        return event


class Recorder:
    """Display and control that remember."""

    def __init__(self):
        self.shown = []
        self.sent = []
        self.closed = False

    def send(self, request):
        self.sent.append(request)

    def note(self, message):
        self.shown.append(str(message))

    def show(self, progress, state):
        self.shown.append((state.code.name, progress.visited_points))

    def close(self):
        self.closed = True


def state(code, survey_id="ours"):
    return ControlState(SurveyState[code], verbatim("as it is"), survey_id, True)


BEGIN = (
    state("IDLE", ""),
    Answer(Request.START, True, verbatim(""), "ours"),
    state("SURVEYING"),
)


def run(clock, *events):
    recorder = Recorder()
    follower = SurveyFollower(Mode.START, OnPause.EXIT, Limits(), clock)
    session = SurveySession(follower, ScriptedEvents(clock, events), recorder.send, recorder)
    return session.run(), recorder, session


def test_operator_sees_the_survey_from_its_plan_to_its_last_trace(clock):
    outcome, recorder, session = run(
        clock,
        state("FINISHED", "former"),
        Progress("former", 100.0, 8, 8, 0.0),
        Accepted(18, 65.0),
        state("CHECKING"),
        Answer(Request.START, True, verbatim(""), "ours"),
        state("SURVEYING"),
        None,
        Progress("ours", 50.0, 18, 9, 30.0),
        state("FINISHED"),
    )
    assert outcome.status is ExitStatus.FINISHED
    assert recorder.sent == [Request.START]
    assert recorder.shown == [
        str(SIMULATED),
        "Parameters accepted: 18 traces, estimated time: 2 min.",
        "CHECKING: as it is",
        "SURVEYING: as it is",
        ("SURVEYING", 9),
    ]
    assert recorder.closed and session.simulated and session.stored


def test_last_trace_is_shown_though_its_word_comes_after_that_of_the_end(clock):
    outcome, recorder, _ = run(
        clock,
        *BEGIN,
        Progress("ours", 94.0, 18, 17, 1.0),
        state("FINISHED"),
        None,
        Progress("former", 100.0, 8, 8, 0.0),
        Progress("ours", 100.0, 18, 18, 0.0),
        Progress("ours", 100.0, 18, 18, 0.0),
    )
    assert outcome.status is ExitStatus.FINISHED
    assert recorder.shown[-1] == ("SURVEYING", 18)


def test_a_state_is_told_once_per_change_and_moves_the_bar(clock):
    _, recorder, _ = run(
        clock,
        *BEGIN,
        state("SURVEYING"),
        Progress("ours", 50.0, 18, 9, 30.0),
        state("CHECKING"),
        state("CHECKING"),
        state("FAILED"),
    )
    assert recorder.shown[1:] == [
        "SURVEYING: as it is",
        ("SURVEYING", 9),
        "CHECKING: as it is",
        ("CHECKING", 9),
    ]


def test_stop_and_its_refusal_are_told(clock):
    _, recorder, _ = run(
        clock,
        *BEGIN,
        StopRequested("Ctrl-C"),
        Answer(Request.STOP, False, verbatim("busy")),
        state("STOPPED"),
    )
    assert recorder.sent == [Request.START, Request.STOP]
    assert "Ctrl-C: stopping the survey." in recorder.shown
    assert "Stop not accepted: busy" in recorder.shown


def test_session_ends_by_itself_when_nobody_speaks(clock):
    outcome, recorder, _ = run(clock)
    assert outcome.status is ExitStatus.REFUSED
    assert recorder.closed


def test_display_is_closed_when_the_session_is_broken_off(clock):
    recorder = Recorder()

    class Broken:
        def get(self, timeout):
            raise KeyboardInterrupt

    follower = SurveyFollower(Mode.START, OnPause.EXIT, Limits(), clock)
    with pytest.raises(KeyboardInterrupt):
        SurveySession(follower, Broken(), recorder.send, recorder).run()
    assert recorder.closed


def lines_of(status, message, simulated=False, stored=False):
    messages = outcome_lines(Outcome(status, message), "an-id", simulated, stored)
    return [str(line) for line in messages]


def test_last_words_tell_outcome_survey_and_simulation():
    for status in ExitStatus:
        lines = lines_of(status, verbatim("why"), simulated=True)
        assert lines[1] == "why"
        assert "Survey id: an-id" in lines
        assert lines[-1] == str(SIMULATED)
        assert any("--resume" in line for line in lines) == (status is ExitStatus.PAUSED)


def test_last_words_tell_how_a_survey_that_ended_early_is_resumed_if_it_can_be():
    lost = Message("{why}", why=LOST)
    for status in ExitStatus:
        lines = lines_of(status, verbatim("why"), stored=True)
        resumable = status in (ExitStatus.STOPPED, ExitStatus.FAILED)
        assert any("run_survey --resume an-id" in line for line in lines) == resumable, status
    for status in (ExitStatus.PAUSED, ExitStatus.STOPPED, ExitStatus.FAILED):
        lines = lines_of(status, lost, stored=True)
        assert not any("--resume" in line for line in lines), status
        ends = any("stop_survey" in line for line in lines)
        assert ends == (status is ExitStatus.PAUSED)


def test_last_words_claim_no_simulation_and_no_survey_that_was_not():
    outcome = Outcome(ExitStatus.REFUSED, verbatim("why"))
    lines = outcome_lines(outcome, "", simulated=False)
    assert [str(line) for line in lines[:2]] == ["No survey was run.", "why"]
    assert lines[2].values["remedy"] == remedies.CHECK_STATUS and len(lines) == 3


def test_the_last_words_have_remedy_and_code_of_a_fault():
    paused = Outcome(ExitStatus.PAUSED, Message("Paused: {reason}.", reason=FULL))
    (step,) = [line for line in outcome_lines(paused, "", False) if line.details]
    assert step == first_step(FULL)
    assert step.values["remedy"] == remedies.MAKE_SPACE and step.details == "disk.full"
    asked = Outcome(ExitStatus.PAUSED, ASKED_PAUSE)
    assert not any("remedy" in line.values for line in outcome_lines(asked, "", False))
