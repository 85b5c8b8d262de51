"""Between the graph and the window, without a graph: messages, STOP, and joining a master."""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

import rosgraph
from fake_clock import FakeClock
from fault_kit import raises_fault
from topics_kit import LIMIT_S, taken

from gpr20_common.faults import ASKED_FOR, NOT_RUNNING, PART_SILENT
from gpr20_common.high.answers import fault_of
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Fault, Message, verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_msgs.msg import CurrentCoordinate, SurveyCoverage, SurveySummary
from gpr20_msgs.srv import ListSurveysResponse, ReadTracesResponse
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.high import robot_stop, ros_events, storage_client
from gpr20_operator.high.control_client import WITHDRAWN, ControlClient
from gpr20_operator.high.storage_client import OFFERS
from gpr20_operator.jobs.job import Service
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request, Senders, StartPlan
from gpr20_survey.axes import AxisId

REMEDY = Message("Free some space on the disk.")
FULL = Message("the disk is full", details="errno 28").with_fault(Fault("disk.full", REMEDY))
TEXT, SENT = str(FULL), fault_of(FULL)


def test_why_something_of_a_survey_failed_has_its_fault_and_remedy_or_its_text():
    coverage = SurveyCoverage(
        planned=9,
        run_starts=[0],
        run_states=[3],
        failures=[f"4: {TEXT}", "7: no template: as it is"],
        failure_faults=[SENT, fault_of(None)],
    )
    runs = storage_client.coverage_runs(coverage)
    assert runs.failures == {4: FULL, 7: verbatim("no template: as it is")}
    response = ReadTracesResponse(
        success=True, survey_id="id", unreadable=[f"3: {TEXT}", "5: torn"], unreadable_faults=[SENT]
    )
    read = OFFERS[Service.TRACES].convert(response)
    assert (read.block.survey_id, read.block.indices.size) == ("id", 0)
    assert read.unreadable == {3: FULL, 5: verbatim("torn")}
    summary = SurveySummary(problem=TEXT, problem_fault=SENT)
    listed = ListSurveysResponse(success=True, surveys=[summary])
    (failed,) = OFFERS[Service.LIST].convert(listed).surveys
    assert failed.verdict is None
    for one in (runs.failures[4], read.unreadable[3], failed.problem):
        assert (one.fault_code, one.remedy) == ("disk.full", REMEDY)


@pytest.fixture
def client(services, events):
    """A client whose request to set the parameters hangs."""
    services.answers["set_survey_parameters"] = [services.hung, {"plan_id": "0123"}]
    services.answers["start_survey"] = [{"survey_id": "s"}]
    client = ControlClient(events.put, Senders("/"))
    client._stop = SimpleNamespace(press=lambda: None, forget=lambda: None)
    return client


@pytest.mark.parametrize("withdraw", [ControlClient.stop, ControlClient.withdraw_start])
def test_a_survey_whose_parameters_are_not_accepted_yet_is_not_started_after_stop(
    client, services, events, withdraw
):
    client.start_survey(StartPlan(default_parameters()))
    assert services.asked.get(timeout=LIMIT_S)[0] == "set_survey_parameters"
    withdraw(client)
    services.hung.set()
    assert events.get(timeout=LIMIT_S) == Answer(Request.START, False, WITHDRAWN)
    assert services.asked.empty()
    # The next one is, with the plan that it has set, whatever another client has set meanwhile.
    client.start_survey(StartPlan(default_parameters()))
    assert events.get(timeout=LIMIT_S).success
    assert dict(taken(services.asked, 2))["start_survey"]["plan_id"] == "0123"


def test_what_axes_report_is_passed_on_as_it_is(client):
    for axis, homed, moving in zip(AxisId, (True, False, True), (False, True, True)):
        said = CurrentCoordinate(coordinate=1.5, homed=homed, moving=moving, owner="/o")
        assert client._measured(axis, said) == AxisReport(axis, 1.5, homed, moving, "/o")


REFUSED = {"success": False}
SILENT = ServiceUnavailableError(Message("no answer"))


@pytest.fixture
def stop(services, events, monkeypatch):
    """STOP, with a clock of its own."""
    monkeypatch.setattr(robot_stop, "Clock", FakeClock)
    monkeypatch.setattr(robot_stop.rospy, "logwarn_throttle", lambda *_given: None)
    stop = robot_stop.RobotStop(events.put)
    yield stop
    stop.forget()


def test_a_stop_that_an_axis_or_the_main_control_did_not_hear_is_repeated_until_it_does(
    stop, services, events
):
    services.answers = {name: [SILENT] * 5 + [{}] for name in ("stop_survey", "x_axis/stop")}
    stop.press()
    found = taken(events, 6)
    of_x = [getattr(one, "answered", None) for one in found if getattr(one, "axis", "") is AxisId.X]
    assert of_x == [False, True]
    answers = [one for one in found if isinstance(one, Answer)]
    assert [(one.success, one.contact) for one in answers] == [(False, False), (True, True)]
    assert answers[0].message.cause == PART_SILENT
    asked = [name for name, _fields in taken(services.asked, 14)]
    assert asked.count("stop_survey") == asked.count("x_axis/stop") == 6
    assert services.asked.empty()


def test_every_press_asks_all_and_none_waits_for_one_that_hangs(stop, services, events):
    services.answers = {
        "x_axis/stop": [SILENT],
        "y_axis/stop": [REFUSED],
        "stop_survey": [services.hung, REFUSED],
    }
    for _press in range(2):
        stop.press()
        answers = [] if services.hung.is_set() else taken(events, 3)
        services.hung.set()
        answers += taken(events, 4 - len(answers))
        axes = {one.axis: one.answered for one in answers if isinstance(one, AxisStopAnswer)}
        assert axes == {AxisId.X: False, AxisId.Y: False, AxisId.Z: True}
        (control,) = [one for one in answers if isinstance(one, Answer)]
        assert (control.request, control.success, control.contact) == (Request.STOP, False, True)


def test_a_stop_is_repeated_no_more_when_something_was_started_since(stop, services, events):
    services.answers = {"stop_survey": [SILENT, services.hung, SILENT]}
    stop.press()
    taken(events, 4)
    asked = [name for name, _fields in taken(services.asked, 5)]
    stop.forget()
    services.hung.set()
    stop._services[-1]._repeating.acquire(timeout=LIMIT_S)
    assert asked.count("stop_survey") == 2 and services.asked.empty()


def test_stop_needs_no_master_once_it_knows_the_address(monkeypatch):
    asked = []

    def look_up(name):
        asked.append(name)
        if isinstance(answer, Exception):
            raise answer
        return answer

    known = SimpleNamespace(lookupService=look_up)
    monkeypatch.setattr(robot_stop.rosgraph, "Master", lambda _name: known)
    monkeypatch.setattr(ServiceClient, "_look_up", lambda *_given: "asked the master")
    client = robot_stop.StopService(None, print, threading.Event())
    assert client._look_up(0, 1.0) == "asked the master"
    answer = "rosrpc://robot:1"
    client.remember()
    # A service that is not there now has its last address; a silent master is said.
    answer = rosgraph.MasterError("unknown service")
    client.remember()
    answer = OSError("refused")
    with pytest.raises(OSError):
        client.remember()
    assert client._look_up(0, 1.0) == "rosrpc://robot:1"
    # Where that fails, it may be a new one.
    assert client._look_up(1, 1.0) == "asked the master"
    assert set(asked) == {"/stop_survey"}


def test_a_graph_is_joined_within_the_limit_or_the_reason_is_said(monkeypatch):
    joined, found = [], iter([False, True])
    monkeypatch.setattr(ros_events, "enable_line_buffering", lambda: None)
    monkeypatch.setattr(ros_events, "answers", lambda *_given: next(found, False))
    monkeypatch.setattr(ros_events.rospy, "init_node", lambda name, **_given: joined.append(name))
    ros_events.join_graph("a_node", 5.0, lambda: False, FakeClock())
    assert joined == ["a_node"]
    for cancelled, fault in ((bool, NOT_RUNNING), (lambda: True, ASKED_FOR)):
        with raises_fault(fault, error=MasterUnavailableError):
            ros_events.join_graph("a_node", 5.0, cancelled, FakeClock())
    assert joined == ["a_node"]
