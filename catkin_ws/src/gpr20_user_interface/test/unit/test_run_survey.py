"""`run_survey` with a main control in this process: real requests and messages, no graph."""

import io
import os
import signal
import threading
import uuid
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

import rospy
from topics_kit import Graph

from gpr20_common.faults import NOT_RUNNING
from gpr20_common.high.answers import message_fields
from gpr20_common.high.service_client import ServiceClient
from gpr20_common.message import Message, verbatim
from gpr20_msgs.msg import ControlStatus, SurveyData
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.high import conversions, ros_events
from gpr20_survey.plan.annotation import Annotation, Wgs84Position, from_fields
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.high import run_survey
from gpr20_user_interface.terminal.follower import ExitStatus

SMALL = ("--x-points", "3", "--y-points", "3")
OTHER_VNA = "Anritsu,MS2026C/2,62011033,1.23"
CODES = {one: getattr(ControlStatus, one.name) for one in SurveyState}


class MainControl(Graph):
    """Answers the services and publishes what happens, under the name of the main control.

    Attributes:
        end: How a survey ends that was started or resumed; None: it goes on until it is stopped.
        connected: The VNA, if it is not that of the survey.
    """

    def __init__(self):
        super().__init__()
        self.end, self.refusal, self.connected = SurveyState.FINISHED, None, ""
        self.reason = verbatim("as it is")
        self.code, self.survey_id, self.total, self.visited = SurveyState.IDLE, "", 0, 0
        self.said = None
        self.requests, self.sender, self._lock = [], "/main_control", threading.RLock()
        self.surveys, self._closed = threading.Event(), threading.Event()
        self.followed = threading.Semaphore(0)
        threading.Thread(target=self._repeat, daemon=True).start()

    def close(self):
        self._closed.set()

    def _repeat(self):
        """Say state and progress again and again, as the real one does."""
        while not self._closed.wait(0.05):
            with self._lock:
                self.send(self.sender, "control_status", self.status(self.said))
                self.progress()

    def subscriber(self, name, *given, **more):
        with self._lock:
            one = super().subscriber(name, *given, **more)
            if name == "control_status":
                self.send(self.sender, name, self.status())
                self.followed.release()
        return one

    def status(self, message=None):
        fields = message_fields(message or verbatim("as it is"))
        return ControlStatus(
            code=CODES[self.code], survey_id=self.survey_id, simulated=True, **fields
        )

    def say(self, code, message=None):
        with self._lock:
            self.code, self.said = code, message
            self.send(self.sender, "control_status", self.status(message))

    def call(self, client, _timeout_s, **fields):
        kind = client._service_class
        request = kind._request_class(**fields)
        request.serialize(io.BytesIO())
        with self._lock:
            self.requests.append((client.name, request))
            values = getattr(self, client.name.replace("/", "_"), dict)(request)
        return kind._response_class(**{"success": True, **message_fields(verbatim("")), **values})

    def asked(self, name):
        return [request for kind, request in self.requests if kind == name]

    def set_survey_parameters(self, request):
        if self.refusal is not None:
            return {"success": False, **message_fields(self.refusal)}
        self.total = conversions.parameters(request.parameters).total_points
        return {"plan_id": "a plan", "total_points": self.total}

    def start_survey(self, request):
        assert request.plan_id == "a plan"
        self.survey_id = str(uuid.uuid4())
        self.go_on()
        return {"survey_id": self.survey_id}

    def resume_survey(self, request):
        if self.connected not in ("", request.accept_analyzer):
            other = message_fields(verbatim("the VNA is another one"))
            return {"success": False, "other_analyzer": self.connected, **other}
        self.go_on()
        return {}

    def go_on(self):
        self.say(SurveyState.CHECKING)
        self.say(SurveyState.SURVEYING)
        self.visited = self.total if self.end is SurveyState.FINISHED else 5
        if self.end is not None:
            self.say(self.end, self.reason)
        self.surveys.set()

    def progress(self):
        self.send(
            self.sender,
            "control_survey_data",
            SurveyData(
                survey_id=self.survey_id,
                completion_percent=100.0 * self.visited / max(self.total, 1),
                total_points=self.total,
                visited_points=self.visited,
                remaining_time=rospy.Duration(self.total - self.visited),
            ),
        )

    def stop_survey(self, _request):
        self.say(SurveyState.STOPPING)
        self.say(SurveyState.STOPPED, verbatim("stopped by request"))
        return {}


class Ended(BaseException):
    """In place of the end of the process."""


@pytest.fixture
def control(monkeypatch):
    control = MainControl()
    monkeypatch.setattr(
        ServiceClient, "call", lambda *given, **fields: control.call(*given, **fields)
    )
    monkeypatch.setattr(ros_events.rospy, "Subscriber", control.subscriber)
    monkeypatch.setattr(run_survey, "join_graph", lambda *_given: None)
    monkeypatch.setattr(run_survey, "GraphKeeper", lambda: SimpleNamespace(close=lambda: None))
    yield control
    control.close()


@pytest.fixture
def run(control, monkeypatch, capsys):
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


def test_a_survey_is_followed_to_its_end_with_what_was_given_for_it(run, control):
    given = ["--operator", "Lucía Peña", "--site", "El Carmen", "--notes", "wet\nsoil"]
    given += ["--position=-4.60283,-74.06514", "--permittivity", "4.5"]
    status, written = run(*SMALL, *given)
    assert status == ExitStatus.FINISHED == 0, written
    (plan,), (start,) = control.asked("set_survey_parameters"), control.asked("start_survey")
    assert (plan.parameters.x_points, plan.parameters.y_points) == (3, 3)
    position = Wgs84Position(-4.60283, -74.06514)
    expected = Annotation("Lucía Peña", "El Carmen", "wet\nsoil", position)
    assert from_fields(start.annotation) == expected and start.permittivity == 4.5
    for part in ("18 traces", "SIMULATED", control.survey_id):
        assert part in written


def test_how_a_survey_ends_is_the_exit_status_in_the_language_of_the_terminal(
    run, control, monkeypatch
):
    control.end, control.reason = (
        SurveyState.PAUSED,
        Message("the disk is full", details="errno 28"),
    )
    monkeypatch.setenv("LANGUAGE", "es")
    found, written = run(*SMALL)
    assert found == ExitStatus.PAUSED == 4, written
    for part in ("el disco está lleno (errno 28)", "trazas", "ROBOT SIMULADO", "--resume"):
        assert part in written


def test_a_refusal_is_said_and_nothing_is_started(run, control, monkeypatch):
    control.refusal = verbatim("x stop is 700 mm; it must lie between 0 and 650 mm")
    status, written = run(*SMALL)
    assert status == 1 and "between 0 and 650 mm" in written
    assert not control.asked("start_survey")
    control.requests.clear()

    def join(*_given):
        raise MasterUnavailableError(Message("no ROS master answers at http://127.0.0.1:9"))

    monkeypatch.setattr(run_survey, "join_graph", join)
    status, written = run(*SMALL)
    assert status == 1 and not control.requests
    assert "http://127.0.0.1:9" in written and NOT_RUNNING.code in written


def send_when_it_surveys(control, *numbers):
    """Send signals to this process from another thread."""

    def send():
        assert control.surveys.wait(30.0)
        for number in numbers:
            os.kill(os.getpid(), number)

    threading.Thread(target=send).start()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_survey_and_waits_for_it(run, control, number):
    control.end = None
    send_when_it_surveys(control, number)
    status, written = run(*SMALL)
    assert status == 130, written
    assert "stopped by request" in written.lower() and len(control.asked("stop_survey")) == 1
    assert {name for name, _request in control.requests if name.endswith("axis/stop")}


def test_a_second_signal_leaves_at_once_and_warns(run, control, monkeypatch):
    control.end = None
    monkeypatch.setattr(control, "stop_survey", lambda _request: send_again() or {}, raising=False)

    def send_again():
        os.kill(os.getpid(), signal.SIGINT)

    send_when_it_surveys(control, signal.SIGINT)
    status, written = run(*SMALL)
    assert status == 130 and "the robot may still move" in written
    assert control.code is SurveyState.SURVEYING


def test_another_vna_is_used_only_if_it_is_accepted(run, control):
    control.end = SurveyState.PAUSED
    run(*SMALL)
    control.end, control.connected = SurveyState.FINISHED, OTHER_VNA
    status, written = run("--resume")
    assert status == 1 and f"--accept-analyzer {OTHER_VNA}" in written
    control.code = SurveyState.PAUSED
    status, written = run("--resume", "--accept-analyzer", OTHER_VNA)
    assert status == 0 and control.survey_id in written
    asked = [one.accept_analyzer for one in control.asked("resume_survey")]
    assert asked == ["", OTHER_VNA]
