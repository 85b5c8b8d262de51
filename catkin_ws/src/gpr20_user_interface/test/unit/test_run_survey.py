"""`run_survey` from its command line to its exit status, with a client that answers by itself."""

import os
import signal
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from view_kit import FULL, past_survey

from gpr20_common.faults import NOT_RUNNING
from gpr20_common.message import Message, verbatim
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.jobs.pictures import SurveysListed
from gpr20_operator.robot.events import Answer, ControlState, Progress, Request
from gpr20_survey.faults import NONE_OPEN
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.high import run_survey

SMALL = ("--x-points", "3", "--y-points", "3")
LISTED = past_survey(), past_survey(survey_id="whole", complete=True)


class Robot:
    """In place of the client of the main control, and of what answers it.

    Attributes:
        end: How a survey ends that was started or resumed; None: it goes on until it is stopped.
        refusal: Why it is not accepted; None: it is.
        signals: What this process gets while the survey runs.
    """

    def __init__(self):
        self.end, self.refusal, self.signals, self.asked = SurveyState.FINISHED, None, [], []

    def __call__(self, listener, _senders):
        self.emit = listener
        return self

    def say(self, code, message):
        self.emit(ControlState(code, message, "the id", True))

    def listen(self):
        self.say(SurveyState.IDLE, verbatim("at rest"))

    def set_watched(self, _watched):
        pass

    def close(self):
        self.asked.append("close")

    def start_survey(self, plan):
        self.asked.append(plan)
        self.answer(Request.START)

    def resume_survey(self, *given):
        self.asked.append(given)
        self.answer(Request.RESUME)

    def answer(self, request):
        if self.refusal is not None:
            self.emit(Answer(request, False, self.refusal))
            return
        self.emit(Answer(request, True, verbatim("accepted"), "the id"))
        self.say(SurveyState.SURVEYING, verbatim("measuring"))
        self.emit(Progress("the id", 0.0, 18, 0, 60.0))
        if self.end is not None:
            self.say(self.end, FULL)
        for number in self.signals:
            os.kill(os.getpid(), number)

    def stop(self):
        self.asked.append("stop")
        self.say(SurveyState.STOPPED, verbatim("stopped by request"))


class Ended(BaseException):
    """In place of the end of the process."""


@pytest.fixture
def robot(monkeypatch):
    robot = Robot()
    keeper = SimpleNamespace(close=lambda: None)
    listed = SimpleNamespace(wait_for=lambda *_, **__: SurveysListed(LISTED, False))
    for name, fake in (
        *(("ControlClient", robot), ("join_graph", lambda *_given: None)),
        *(("GraphKeeper", lambda: keeper), ("StorageClient", lambda *_given: listed)),
    ):
        monkeypatch.setattr(run_survey, name, fake)
    return robot


@pytest.fixture
def run(robot, monkeypatch, capsys):
    """Run the client as from a terminal; return its exit status and what it has written."""
    monkeypatch.setenv("LANGUAGE", "en")

    def leave_now(status):
        raise Ended(status)

    monkeypatch.setattr(run_survey, "leave_now", leave_now)

    def run(*arguments):
        monkeypatch.setattr(run_survey.rospy, "myargv", lambda: ["run_survey", *arguments])
        try:
            status = run_survey.main()
        except Ended as ended:
            (status,) = ended.args
        written = capsys.readouterr()
        return status, written.out + written.err

    return run


def test_a_survey_is_followed_to_its_end_with_what_was_given_for_it(run, robot):
    given = ["--operator", "Lucía Peña", "--site", "El Carmen", "--notes", "wet\nsoil"]
    given += ["--position=-4.60283,-74.06514", "--permittivity", "4.5"]
    status, written = run(*SMALL, *given)
    assert status == 0, written
    plan, closed = robot.asked
    assert (plan.parameters.x_points, plan.parameters.y_points, plan.permittivity) == (3, 3, 4.5)
    position = Wgs84Position(-4.60283, -74.06514)
    assert plan.annotation == Annotation("Lucía Peña", "El Carmen", "wet\nsoil", position)
    assert closed == "close"
    for part in ("0/18 traces", "SIMULATED", "the id"):
        assert part in written


def test_how_a_survey_ends_is_the_exit_status_in_the_language_of_the_terminal(
    run, robot, monkeypatch
):
    monkeypatch.setenv("LANGUAGE", "es")
    for robot.end, expected in ((SurveyState.PAUSED, 4), (SurveyState.FAILED, 3)):
        status, written = run(*SMALL)
        assert status == expected, written
        for part in ("el disco está lleno (errno 28)", "ROBOT SIMULADO", "--resume"):
            assert part in written


def test_the_named_survey_is_resumed_and_a_refusal_is_said(run, robot, monkeypatch):
    status, written = run("--resume", "/data/7")
    assert status == 0 and robot.asked[0] == ("7",)
    robot.asked.clear()
    robot.refusal = verbatim("the VNA is another one")
    status, written = run("--resume")
    assert status == 1 and robot.asked[0] == ("",)
    assert "the VNA is another one" in written and "run_survey --resume" not in written
    robot.refusal = verbatim("no survey is open").with_fault(NONE_OPEN)
    status, written = run("--resume")
    assert status == 1 and f"run_survey --resume {LISTED[0].survey_id}`" in written
    assert "whole" not in written
    robot.asked.clear()

    def join(*_given):
        raise MasterUnavailableError(Message("no ROS master answers at http://127.0.0.1:9"))

    monkeypatch.setattr(run_survey, "join_graph", join)
    status, written = run(*SMALL)
    assert status == 1 and robot.asked == []
    assert "http://127.0.0.1:9" in written and NOT_RUNNING.code in written


def test_a_signal_stops_the_survey_and_a_second_one_leaves_at_once(run, robot):
    robot.end = None
    for number in (signal.SIGINT, signal.SIGTERM):
        robot.signals = [number]
        status, written = run(*SMALL)
        assert status == 130 and "stopped by request" in written
        assert robot.asked[1] == "stop"
        robot.asked.clear()
        robot.signals = [number, signal.SIGINT]
        status, written = run(*SMALL)
        assert status == 130 and "the robot may still move" in written
        assert "stop" not in robot.asked
        robot.asked.clear()
