"""Clients of the graph without one: STOP, and joining a master that comes, dies or is another."""

import threading
from types import SimpleNamespace

import pytest
import rosgraph
from fake_clock import FakeClock
from fault_kit import raises_fault
from topics_kit import LIMIT_S, Graph, taken

from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_msgs.msg import ControlStatus
from gpr20_msgs.srv import Command
from gpr20_operator import faults
from gpr20_operator.errors import MasterUnavailableError
from gpr20_operator.high import master, robot_stop, robots_client
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.robots import RobotReported, RobotsFound
from gpr20_operator.robot.senders import Senders
from gpr20_survey.axes.axis_id import AxisId

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


def test_every_press_asks_every_axis_and_the_main_control_whatever_they_answer(
    stop, services, events
):
    services.answers = {"x_axis/stop": [SILENT], "y_axis/stop": [REFUSED], "stop_survey": [REFUSED]}
    for _press in range(2):
        stop.press()
        answers = taken(events, 4)
        axes = {one.axis: one.answered for one in answers if isinstance(one, AxisStopAnswer)}
        assert axes == {AxisId.X: False, AxisId.Y: False, AxisId.Z: True}
        (control,) = [one for one in answers if isinstance(one, Answer)]
        assert (control.request, control.success, control.contact) == (Request.STOP, False, True)


def test_no_axis_waits_for_a_main_control_or_an_axis_that_hangs(stop, services, events):
    services.answers = {name: [services.hung, {}] for name in ("stop_survey", "x_axis/stop")}
    stop.press()
    assert {one.axis for one in taken(events, 2)} == {AxisId.Y, AxisId.Z}


def test_a_stop_that_the_main_control_did_not_hear_is_repeated_until_it_does(
    stop, services, events
):
    services.answers = {"stop_survey": [SILENT] * 5 + [{}]}
    stop.press()
    answers = [one for one in taken(events, 5) if isinstance(one, Answer)]
    assert [(one.success, one.contact) for one in answers] == [(False, False), (True, True)]
    assert answers[0].message.cause == faults.PART_SILENT
    asked = [name for name, _fields in taken(services.asked, 9)]
    assert asked.count("stop_survey") == 6 and services.asked.empty()


def test_a_stop_is_repeated_no_more_when_something_was_started_since(stop, services, events):
    services.answers = {"stop_survey": [SILENT, services.hung, SILENT]}
    stop.press()
    taken(events, 4)
    asked = [name for name, _fields in taken(services.asked, 5)]
    stop.forget()
    services.hung.set()
    stop._repeating.acquire(timeout=LIMIT_S)
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
    client = robot_stop.DirectServiceClient("stop_survey", Command)
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


class WaitingClock(FakeClock):
    """Lets other threads work while its time passes."""

    def wait_s(self, event, timeout_s):
        self.advance(timeout_s)
        return event.wait(0.01)


def test_a_graph_is_joined_within_the_limits_or_the_reason_is_said(monkeypatch):
    hung = threading.Event()
    monkeypatch.setattr(master, "enable_line_buffering", lambda: None)
    monkeypatch.setattr(master.rosgraph, "is_master_online", lambda: True)
    monkeypatch.setattr(master.rospy, "init_node", lambda *_, **__: None)
    master.join_graph("a_node", 5.0, lambda: False, WaitingClock())
    monkeypatch.setattr(master.rospy, "init_node", lambda *_, **__: hung.wait(LIMIT_S))
    with raises_fault(faults.NO_MASTER, error=MasterUnavailableError):
        master.join_graph("a_node", 5.0, lambda: False, WaitingClock())
    hung.set()
    monkeypatch.setattr(master.rosgraph, "is_master_online", lambda: False)
    for cancelled, fault in ((bool, faults.NO_MASTER), (lambda: True, faults.NOT_STARTED)):
        with raises_fault(fault, error=MasterUnavailableError):
            master.join_graph("a_node", 5.0, cancelled, WaitingClock())


def test_everything_is_registered_again_with_another_master_and_only_then(monkeypatch):
    process_ids, registered = [7, 7, 8, 8, 9], []
    known = SimpleNamespace(getPid=lambda: process_ids.pop(0))
    monkeypatch.setattr(master.rosgraph, "Master", lambda _name: known)
    listeners = SimpleNamespace(notify_added=lambda *given: registered.append(given[0]))
    monkeypatch.setattr(master, "get_registration_listeners", lambda: listeners)
    manager = SimpleNamespace(
        get_subscriptions=lambda: [("/heard", "a/Type")],
        get_publications=lambda: [("/said", "a/Type")],
        get_services=lambda: [("/asked", "rosrpc://here")],
    )
    for name in ("get_topic_manager", "get_service_manager"):
        monkeypatch.setattr(master, name, lambda: manager)
    watch, counts = master.MasterWatch(), []
    for _ in range(5):
        watch.check()
        counts.append(len(registered))
    assert counts == [0, 0, 3, 3, 6]
    assert set(registered) == {"/heard", "/said", "/asked"}


def test_other_robots_are_listened_to_only_while_their_list_is_looked_at(monkeypatch):
    services = [
        f"{robot}/{name}" for robot in ("", "/beside") for name in ("start_survey", "stop_survey")
    ]
    state = SimpleNamespace(getSystemState=lambda: ([], [], [(name, []) for name in services]))
    monkeypatch.setattr(robots_client.rosgraph, "Master", lambda _name: state)
    monkeypatch.setattr(robots_client, "in_background", lambda work: work())
    monkeypatch.setattr(robots_client, "Periodic", lambda _period_s, act: act())
    graph, events = Graph(), []
    monkeypatch.setattr(robots_client.rospy, "Subscriber", graph.subscriber)
    client = robots_client.RobotsClient(events.append, Senders("/"))
    client.listen()
    assert events == [RobotsFound(frozenset({"/", "/beside"}))] and not graph.subscribers
    client.set_watched(True)
    topics = {one.name for one in graph.subscribers}
    assert topics == {"/control_status", "/beside/control_status"}
    for sender in ("/play_1", "/main_control", "/beside/main_control"):
        graph.send(sender, "/beside/control_status", ControlStatus(code=ControlStatus.PAUSED))
    (report,) = [one for one in events if isinstance(one, RobotReported)]
    assert (report.namespace, report.state.code.name) == ("/beside", "PAUSED")
    client.close()
    assert not graph.subscribers
