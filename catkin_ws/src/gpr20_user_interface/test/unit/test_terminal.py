"""The terminal client: its command line, how it follows a survey, its lines and exit statuses."""

import contextlib
import dataclasses
import io
import itertools
import os
import signal
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from case_kit import each_case
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as st
from view_kit import FULL, LOST

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_RUNNING, PART_LOST
from gpr20_common.message import Message, verbatim
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.plan.fields import PARAMETERS, PEOPLE
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL, Answer, ControlState, Progress, Request
from gpr20_survey.faults import CAN_RESUME
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_parameters import check_output_power, find_problems
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.high import run_survey
from gpr20_user_interface.terminal import (
    TICK_S,
    Display,
    ExitStatus,
    SurveyFollower,
    option_of,
    parse_arguments,
)


def options_of(line):
    return parse_arguments(line.split(), Catalogue())


def test_the_defaults_can_be_run_and_assume_no_soil():
    options = options_of("")
    assert find_problems(options.plan.parameters, DOCUMENTED_TRAVEL) == []
    assert (options.plan.permittivity, options.resume) == (0.0, None)
    folder = "20260921T141320_0f8fad5b"
    for line, resume in (("--resume", ""), (f"--resume /data/{folder}/", folder)):
        assert options_of(line).resume == resume
    with pytest.raises(SystemExit, match="2"), contextlib.redirect_stderr(io.StringIO()):
        options_of("--resume --permittivity 4")
    with pytest.raises(SystemExit, match="2"), contextlib.redirect_stderr(io.StringIO()):
        options_of("--output-power MAX")


@given(st.sampled_from((*PARAMETERS, *PEOPLE)), st.text(max_size=10))
def test_the_command_line_reads_what_the_window_reads_and_refuses_the_rest(spec, text):
    argument = f"{option_of(spec)}={text}"
    try:
        wanted = spec.kind.read(text)
        if spec.name == "output_power":
            check_output_power(wanted)
    except InvalidValueError:
        with pytest.raises(SystemExit, match="2"), contextlib.redirect_stderr(io.StringIO()):
            parse_arguments([argument], Catalogue())
        return
    plan = parse_arguments([argument], Catalogue()).plan
    record = plan.parameters if spec in PARAMETERS else plan.annotation
    assert getattr(record, spec.name) == wanted


STARTED = Answer(Request.START, True, verbatim("started"), "ours")
RESUMED = Answer(Request.RESUME, True, verbatim("resumed"))
STOP = Request.STOP


def state(code, survey_id="ours", message="as it is"):
    said = verbatim(message) if isinstance(message, str) else message
    return ControlState(SurveyState[code], said, survey_id, True)


def progress(survey_id="ours", visited=9):
    return Progress(survey_id, visited / 0.18, 18, visited, 10.0)


IDLE = state("IDLE", "")
BEGIN = (IDLE, STARTED, state("SURVEYING"))


class Client:
    """The follower with its clock, what it has asked for, and what it has written."""

    def __init__(self, *events, line="--wait 10"):
        self.clock, self.requests, self.stream = FakeClock(), [], io.StringIO()
        control = SimpleNamespace(
            start_survey=lambda _plan: self.requests.append("start"),
            resume_survey=lambda survey: self.requests.append(f"resume {survey}"),
            stop=lambda: self.requests.append("stop"),
        )
        display = Display(self.stream, Catalogue())
        self.follower = SurveyFollower(options_of(line), control, display, self.clock)
        self.say(*events)

    def say(self, *events):
        for event in events:
            if self.status is None:
                self.follower.take(event)
        return self

    def wait(self, seconds, spoken=None):
        """Let time pass; the main control may speak at each second."""
        for number in range(round(seconds / TICK_S)):
            self.clock.advance(TICK_S)
            self.say(spoken if number % 5 == 0 else None)
        return self

    @property
    def status(self):
        return self.follower.status

    @property
    def code(self):
        return self.follower.message.fault_code

    @property
    def lines(self):
        return self.stream.getvalue().splitlines()

    @property
    def last_words(self):
        return "\n".join(map(str, self.follower.last_words()))


def test_a_survey_is_asked_for_once_when_the_main_control_is_heard():
    for line, request in (("", "start"), ("--resume 7", "resume 7")):
        client = Client(line=line)
        assert client.requests == []
        client.say(IDLE, state("CONFIGURED", ""), progress(""))
        # A long start is waited for.
        client.wait(600, state("HOMING"))
        assert (client.requests, client.status) == ([request], None)


@each_case(
    "code, message, status, resumed",
    [
        ("FINISHED", "why", ExitStatus.FINISHED, False),
        ("FAILED", "why", ExitStatus.FAILED, True),
        ("FAILED", LOST, ExitStatus.FAILED, False),
        ("STOPPED", "why", ExitStatus.FAILED, True),
        ("PAUSED", "why", ExitStatus.PAUSED, True),
        ("PAUSED", LOST, ExitStatus.PAUSED, False),
    ],
)
def test_the_end_of_the_survey_is_the_exit_status_and_says_how_to_continue(
    code, message, status, resumed
):
    client = Client(*BEGIN, progress(), state(code, message=message))
    assert (client.status, client.requests) == (status, ["start"])
    assert str(message) in client.last_words and "Survey id: ours" in client.last_words
    assert ("run_survey --resume ours" in client.last_words) is resumed
    assert ("Do this first" in client.last_words) is (message is LOST)


def test_the_end_of_a_former_survey_is_not_taken_for_ours_and_ours_is_not_missed():
    # The latched status says how the survey before this one ended.
    client = Client(state("FINISHED", "former"), STARTED, state("FINISHED", "former"))
    assert client.status is None
    client.say(state("CHECKING"), state("FAILED", message="VNA absent"))
    assert client.status is ExitStatus.FAILED
    # It ended, and another plan was set, while the client heard nothing.
    later = dataclasses.replace(state("CONFIGURED"), end=SurveyState.FINISHED)
    client = Client(*BEGIN).wait(20).say(later)
    assert client.status is ExitStatus.FINISHED and client.last_words.startswith("FINISHED\n")
    # It ended before the answer came.
    client = Client(IDLE, state("SURVEYING"), state("FINISHED"))
    assert client.status is None and client.say(STARTED).status is ExitStatus.FINISHED
    # A survey that is resumed was paused, or has ended, before.
    for former in ("PAUSED", "STOPPED", "FAILED"):
        client = Client(state(former), state(former), RESUMED, state(former))
        assert client.status is None, former
        client.say(state("CHECKING"), state("SURVEYING"), progress(), state("FINISHED"))
        assert client.status is ExitStatus.FINISHED and "id: ours" in client.last_words


def test_a_refusal_is_said_with_its_reason_and_what_to_do():
    reason = verbatim("the VNA is B, not A").with_fault(NOT_RUNNING)
    client = Client(state("PAUSED"), Answer(Request.RESUME, False, reason, other_analyzer="B C"))
    assert (client.status, client.requests) == (ExitStatus.REFUSED, ["start"])
    said = client.last_words
    assert "the VNA is B, not A" in said and NOT_RUNNING.code in said and "--resume" not in said


def test_silence_is_waited_for_within_its_limit_and_said():
    client = Client().wait(9)
    assert client.status is None
    assert client.wait(2).status is ExitStatus.REFUSED and client.code == NOT_RUNNING.code
    client = Client(*BEGIN).wait(6)
    assert client.status is None and "may still move" in "".join(client.lines[-2:])
    assert client.say(state("SURVEYING")).wait(30).status is None
    assert client.wait(11).status is ExitStatus.FAILED and client.code == PART_LOST.code
    # A client that was suspended itself has not heard anything.
    client = Client(*BEGIN)
    client.clock.advance(5000.0)
    assert client.say(None).status is None


OF_OTHERS = (IDLE, state("CONFIGURED", ""), state("SURVEYING", "of another"))
RESUMES = (IDLE, RESUMED), (state("PAUSED"), RESUMED)


@each_case(
    "events, spoken, silent_s",
    [
        *itertools.product((BEGIN, BEGIN[:2]), OF_OTHERS, (0, 20)),
        *itertools.product(RESUMES, (IDLE,), (0, 20)),
    ],
)
def test_a_main_control_that_was_restarted_does_not_know_the_survey(events, spoken, silent_s):
    client = Client(*events).wait(silent_s).wait(9, spoken)
    assert client.status is ExitStatus.FAILED
    assert "main control was restarted" in client.last_words
    assert client.code in (PART_LOST.code, CAN_RESUME.code)
    assert ("run_survey --resume ours" in client.last_words) is (STARTED in events)


def test_ctrl_c_stops_the_survey_and_waits_for_its_end():
    client = Client(STOP)
    assert client.status is ExitStatus.STOPPED and client.requests == []
    client = Client(*BEGIN, STOP)
    assert client.requests == ["start", "stop"] and client.status is None
    client.say(state("PAUSED"), state("STOPPING")).wait(50, state("STOPPING"))
    assert client.say(state("STOPPED")).status is ExitStatus.STOPPED
    assert Client(*BEGIN, STOP, state("FAILED")).status is ExitStatus.FAILED
    # Before the answer: the survey begins all the same, and is stopped then; or it is withdrawn.
    client = Client(IDLE, STOP, STARTED, state("CHECKING"))
    assert client.requests == ["start", "stop", "stop"] and client.status is None
    withdrawn = Answer(Request.START, False, verbatim("withdrawn"))
    assert Client(IDLE, STOP, withdrawn).status is ExitStatus.STOPPED
    # A STOP that nobody answers is repeated by a client that lives.
    for spoken in (None, state("STOPPING")):
        client = Client(*BEGIN, STOP).wait(800, spoken)
        assert client.status is None
        assert client.wait(200, spoken).status is ExitStatus.FAILED


class Robot:
    """In place of the client of the main control, and of what answers it.

    Attributes:
        end: How a survey ends that was started; None: it goes on until it is stopped.
        signals: What this process gets while the survey runs.
    """

    def __init__(self):
        self.end, self.signals, self.asked = SurveyState.FINISHED, [], []

    def __call__(self, listener, _senders):
        self.emit = listener
        return self

    def listen(self):
        self.emit(IDLE)

    def set_watched(self, _watched):
        pass

    def close(self):
        self.asked.append("close")

    def start_survey(self, plan):
        self.asked.append(plan)
        for event in (*BEGIN[1:], progress(visited=0)):
            self.emit(event)
        if self.end is not None:
            self.emit(state(self.end.name, message=FULL))
        for number in self.signals:
            os.kill(os.getpid(), number)

    def stop(self):
        self.asked.append("stop")
        self.emit(state("STOPPED", message="stopped by request"))


class Ended(BaseException):
    """In place of the end of the process."""


@pytest.fixture
def robot(monkeypatch):
    robot = Robot()
    keeper = SimpleNamespace(close=lambda: None)
    for name, fake in (
        *(("ControlClient", robot), ("join_graph", lambda *_given: None)),
        *(("GraphKeeper", lambda: keeper), ("leave_now", leave_now)),
    ):
        monkeypatch.setattr(run_survey, name, fake)
    return robot


def leave_now(status):
    raise Ended(status)


@pytest.fixture
def run(robot, monkeypatch, capsys):
    """Run the client as from a terminal; return its exit status and what it has written."""
    monkeypatch.setenv("LANGUAGE", "es")

    def run(*arguments):
        monkeypatch.setattr(run_survey.rospy, "myargv", lambda: ["run_survey", *arguments])
        try:
            status = run_survey.main()
        except Ended as ended:
            (status,) = ended.args
        written = capsys.readouterr()
        return status, written.out + written.err

    return run


def test_a_survey_is_followed_to_its_end_in_the_language_of_the_terminal(run, robot, monkeypatch):
    given = ["--x-points", "3", "--operator", "Lucía Peña", "--notes", "wet\nsoil"]
    given += ["--position=-4.60283,-74.06514", "--permittivity", "4.5"]
    for robot.end, expected in (
        *((SurveyState.FINISHED, 0), (SurveyState.PAUSED, 4), (SurveyState.FAILED, 3)),
    ):
        status, written = run(*given)
        assert status == expected, written
        plan, closed = robot.asked
        assert (plan.parameters.x_points, plan.permittivity, closed) == (3, 4.5, "close")
        position = Wgs84Position(-4.60283, -74.06514)
        assert plan.annotation == Annotation("Lucía Peña", "", "wet\nsoil", position)
        for part in ("0/18 trazas", "ROBOT SIMULADO", "el disco está lleno (errno 28)", "ours"):
            assert part in written
        assert ("--resume ours" in written) is bool(expected)
        robot.asked.clear()

    def join(*_given):
        raise MasterUnavailableError(Message("no ROS master answers at http://127.0.0.1:9"))

    monkeypatch.setattr(run_survey, "join_graph", join)
    status, written = run()
    assert status == 1 and robot.asked == []
    assert "http://127.0.0.1:9" in written and NOT_RUNNING.code in written


def test_a_signal_stops_the_survey_and_a_second_one_leaves_at_once(run, robot):
    robot.end = None
    for number in (signal.SIGINT, signal.SIGTERM):
        robot.signals = [number]
        status, written = run()
        assert status == 130 and "stopped by request" in written
        assert robot.asked[1] == "stop"
        robot.asked.clear()
        robot.signals = [number, signal.SIGINT]
        status, written = run()
        assert status == 130 and "el robot puede seguir moviéndose" in written
        assert "stop" not in robot.asked
        robot.asked.clear()
