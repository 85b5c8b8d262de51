"""What a terminal shows of a survey: its lines, its last words, times, and a question."""

import os
import pty
import queue
import re
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_fault_messages import ASKED_PAUSE, FULL, LOST

from gpr20_common import remedies
from gpr20_common.message import Message, verbatim
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    Progress,
    Request,
)
from gpr20_operator.words import duration
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.terminal.displays import is_confirmed, remaining
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


class Recorder:
    """A display that remembers."""

    def __init__(self):
        self.shown, self.closed = [], False

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
    """Follow a survey; where there is no event, time passes."""
    left, recorder = iter(events), Recorder()

    def get(timeout):
        event = next(left, None)
        if event is None:
            clock.advance(timeout)
            raise queue.Empty
        return event

    follower = SurveyFollower(Mode.START, OnPause.EXIT, Limits(), clock)
    session = SurveySession(follower, SimpleNamespace(get=get), [].append, recorder)
    return session.run(), recorder


def test_a_state_is_told_once_per_change_and_the_last_trace_though_it_comes_after_the_end(clock):
    outcome, recorder = run(
        clock,
        *BEGIN,
        state("SURVEYING"),
        Progress("ours", 50.0, 18, 9, 30.0),
        state("CHECKING"),
        state("CHECKING"),
        state("FINISHED"),
        None,
        Progress("former", 100.0, 8, 8, 0.0),
        Progress("ours", 100.0, 18, 18, 0.0),
        Progress("ours", 100.0, 18, 18, 0.0),
    )
    assert outcome.status is ExitStatus.FINISHED
    assert recorder.closed
    assert recorder.shown[1:] == [
        "SURVEYING: as it is",
        ("SURVEYING", 9),
        "CHECKING: as it is",
        ("CHECKING", 9),
        ("CHECKING", 18),
    ]


def lines_of(status, message, simulated=False, stored=False):
    messages = outcome_lines(Outcome(status, message), "an-id", simulated, stored)
    return [str(line) for line in messages]


def test_last_words_tell_how_a_survey_that_ended_early_is_resumed_if_it_can_be():
    lost = Message("{why}", why=LOST)
    for status in ExitStatus:
        lines = lines_of(status, verbatim("why"), simulated=True, stored=True)
        assert lines[1] == "why" and lines[-1] == str(SIMULATED) and "Survey id: an-id" in lines
        resumable = status in (ExitStatus.STOPPED, ExitStatus.FAILED)
        assert any("run_survey --resume an-id" in line for line in lines) == resumable, status
    for status in (ExitStatus.PAUSED, ExitStatus.STOPPED, ExitStatus.FAILED):
        lines = lines_of(status, lost, stored=True)
        assert not any("--resume" in line for line in lines), status
        ends = any("stop_survey" in line for line in lines)
        assert ends == (status is ExitStatus.PAUSED)


def test_the_last_words_have_remedy_and_code_of_a_fault():
    paused = Outcome(ExitStatus.PAUSED, Message("Paused: {reason}.", reason=FULL))
    (step,) = [line for line in outcome_lines(paused, "", False) if line.details]
    assert step == first_step(FULL)
    assert step.values["remedy"] == remedies.MAKE_SPACE and step.details == "disk.full"
    asked = Outcome(ExitStatus.PAUSED, ASKED_PAUSE)
    assert not any("remedy" in line.values for line in outcome_lines(asked, "", False))


DAY_S = 86400


@given(st.integers(min_value=60, max_value=400 * DAY_S))
def test_a_time_is_rounded_up_by_less_than_its_last_unit(time_s):
    assert str(duration(-3)) == str(duration(59.9)) == "less than 1 min"
    words = str(duration(time_s))
    units = {"d": DAY_S, "h": 3600, "min": 60}
    parts = re.findall(r"(\d+) (d|h|min)", words)
    said_s = sum(int(number) * units[unit] for number, unit in parts)
    assert 0 <= said_s - time_s < units[parts[-1][1]]


def test_time_that_is_left_says_what_it_is_based_on():
    for visited, basis in ((0, "by the plan"), (1, "measured"), (12, "measured")):
        progress = Progress("id", 0.0, 18, visited, 1128.0)
        assert str(remaining(progress)) == f"19 min left ({basis})"


@pytest.fixture
def keyboard(monkeypatch):
    """Descriptor on which a test types; the question reads the other end."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "r") as stream:
        monkeypatch.setattr("sys.stdin", stream)
        yield ours
    os.close(ours)


@pytest.mark.needs("terminals")
def test_only_a_clear_yes_confirms(keyboard, capsys):
    for typed in ("y", "Yes", "s", "sí", "n", "", "x"):
        os.write(keyboard, f"{typed}\n".encode())
        confirmed = is_confirmed("Continue?", lambda: False)
        assert confirmed is (typed not in ("n", "", "x")), typed
        assert capsys.readouterr().out.startswith("Continue? ")

    assert not is_confirmed("Continue?", lambda: True)


def test_an_input_that_ends_is_no(monkeypatch):
    with open(os.devnull) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        assert not is_confirmed("Continue?", lambda: False)
