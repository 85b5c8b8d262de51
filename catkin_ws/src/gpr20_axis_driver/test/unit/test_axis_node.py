"""What the node of an axis answers and publishes: its handlers, called without a graph."""

import contextlib
import dataclasses
import socket
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest
from case_kit import each_case

pytest.importorskip("rospy")
pytest.importorskip("gpr20_msgs.msg")
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20/test/unit"))
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_common/test/unit"))

from axis_machine import SHORT, Z_PARAMETERS, Axis
from graph_in_process import Graph
from vanishing_peer import come_back, vanish
from wait_kit import wait_until

from gpr20_axis_driver import controller
from gpr20_axis_driver.faults import AxisException
from gpr20_axis_driver.high import axis_node
from gpr20_axis_driver.high.goals import ENDED, LISTED_GOALS, GoalServer, watch
from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_SET_UP, OVERLOADED
from gpr20_common.high.answers import message_from
from gpr20_common.high.diagnostics import ERROR, OK, WARN
from gpr20_common.message import Message
from gpr20_msgs.msg import AxisGoal
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CONTROL_SILENT, ENDSTOP, NOT_HOMED

CONTROL, OTHER = "/main_control", "/rostopic_7"
FAR_MM = 20.0


class Goals:
    """The server of the action: which goal is under way, and how it ended."""

    sender, connections, preempted, gone = CONTROL, [], False, False

    def __init__(self, _name, _action, execute, check_sender):
        self.execute, self.check_sender = execute, check_sender
        self.ends = []

    def start(self):
        pass

    def stop_status(self):
        pass

    def is_preempt_requested(self):
        return self.preempted

    def __getattr__(self, name):
        state = name.replace("set_", "")
        return lambda result, text: self.ends.append((state, result))


class Node:
    """The node of an axis over pins at no cost of time, and who calls it."""

    def __init__(self, monkeypatch, axis_id=AxisId.X):
        parameters = SHORT if axis_id is AxisId.X else Z_PARAMETERS
        self.graph = Graph(monkeypatch)
        monkeypatch.setattr(axis_node, "GoalServer", Goals)
        monkeypatch.setattr(axis_node, "advertise_watched", axis_node.advertise)
        monkeypatch.setattr(axis_node, "watch", lambda *_client: lambda: self.goals.gone)
        self.axis = Axis(parameters, start_steps=500 if parameters.finds_zero else 0)
        self.node = axis_node.AxisNode(axis_id, parameters, self.axis.driver)
        self.goals = self.node._server
        self.tick, self.health = self.graph.ticks[-1], self.graph.health

    def call(self, service, caller=CONTROL, **fields):
        return self.graph.ask(service, client=caller, **fields)

    def move(self, target):
        self.goals.execute(AxisGoal(target_coordinate=target))
        return self.goals.ends[-1]

    def in_motion(self, act, pulses=300):
        """Act once in the next motion, after so many pulses; a pulse may be late [s] by it."""
        calls = iter([None] * 2 * pulses)

        def sleep():
            if next(calls, act) is None:
                return 0.0
            self.axis.clock.oversleep_s = lambda: 0.0
            late_s = act()
            return late_s if isinstance(late_s, float) else 0.0

        self.axis.clock.oversleep_s = sleep

    @property
    def coordinates(self):
        return self.graph.published["current_coord"]


@pytest.fixture
def node(monkeypatch):
    return Node(monkeypatch)


@pytest.fixture
def homed(node):
    assert node.call("homing").success
    return node


def fault_of(answer):
    assert not answer.success and message_from(answer).fault_code == answer.fault.code
    return answer.fault.code


def test_a_goal_before_homing_is_aborted_and_so_is_one_when_the_node_has_ended(node):
    state, result = node.move(5.0)
    assert (state, fault_of(result)) == ("aborted", NOT_HOMED.code)
    assert node.axis.machine.pulses == []
    level, message, _values = node.health()
    assert (level, message.fault_code) == (ERROR, NOT_HOMED.code)
    for hook in node.graph.hooks:
        hook()
    # The pins are released, and nothing moves any more.
    assert node.axis.machine.directions == {}
    assert fault_of(node.move(1.0)[1]) == IN_USE.code


def test_homing_and_a_move_end_where_they_should_and_the_result_names_the_zero(homed):
    # A stop before it does not end it.
    stop(homed)
    state, result = homed.move(12.34)
    assert (state, result.success, result.coordinate) == ("succeeded", True, 12.34)
    assert homed.axis.machine.steps == 1234
    zero = homed.axis.driver.position.zero
    assert (result.zero_epoch, result.zero_time.to_nsec()) == (zero.number, 1000 * zero.time_us)
    # The resting coordinate is published before the result.
    last = homed.coordinates[-1]
    assert (last.coordinate, last.homed, last.moving) == (12.34, True, False)
    assert (last.zero_epoch, last.zero_time) == (result.zero_epoch, result.zero_time)
    assert homed.health()[0] == OK


def cancel(node):
    node.goals.preempted = True


def stop(node):
    assert node.call("stop", OTHER).success


def lose_contact(node):
    node.goals.gone = True


def lapse(node):
    node.node._lease._now_s = lambda: 1e9


def shut_down(node):
    node.node._stops += 1


@each_case(
    "ends, fault",
    [
        *(((one,), ASKED_FOR) for one in (cancel, stop, shut_down)),
        *(((one,), CONTROL_SILENT) for one in (lose_contact, lapse)),
        # A requested stop counts, even if the contact was lost as well.
        *(((one, stop), ASKED_FOR) for one in (lose_contact, lapse)),
    ],
)
def test_what_ends_a_motion_lets_it_ramp_down_to_an_exact_coordinate(monkeypatch, ends, fault):
    node = Node(monkeypatch)
    node.call("homing")
    assert lapse not in ends or node.call("lease").success
    node.in_motion(lambda: [end(node) for end in ends])
    state, result = node.move(FAR_MM)
    assert (state, fault_of(result)) == ("preempted", fault.code)
    assert 3.0 < result.coordinate < 5.0 and node.coordinates[-1].homed
    assert not node.axis.driver.moving
    assert node.axis.machine.steps == round(100 * result.coordinate)
    if lapse not in ends and ends[0] in (stop, lose_contact):
        # A homing that is ended leaves the axis not homed, and nothing is wrong with it.
        node.goals.gone = False
        node.in_motion(lambda: [end(node) for end in ends], pulses=50)
        assert fault_of(node.call("homing")) == fault.code
        assert node.axis.machine.steps > 100 and not node.coordinates[-1].homed
        level, message, _values = node.health()
        assert (level, message.fault_code) == (WARN, NOT_HOMED.code)


def test_while_a_node_has_the_axis_nobody_else_moves_it_or_sets_its_zero(monkeypatch):
    # Only an axis without endstop can be given a zero.
    assert set(Node(monkeypatch).graph.services) == {"homing", "stop", "lease"}
    node = Node(monkeypatch, AxisId.Z)
    zero = node.axis.driver.position.zero
    lease = node.call("lease")
    assert lease.success and lease.limit_s == Z_PARAMETERS.lease_limit_s
    for service in ("homing", "set_zero", "lease"):
        answer = node.call(service, OTHER)
        assert fault_of(answer) == IN_USE.code
        assert message_from(answer).values["owner"] == CONTROL
    assert node.axis.driver.position.zero == zero and node.axis.machine.pulses == []
    assert node.call("lease", lease=lease.lease).lease == lease.lease
    assert fault_of(node.call("lease", lease=lease.lease + 1)) == CONTROL_SILENT.code
    assert node.call("lease", lease=lease.lease, release=True).success
    assert node.call("set_zero", OTHER).success
    assert node.axis.driver.position.zero.number == zero.number + 1


def test_coordinate_and_owner_are_published_all_the_time(homed, monkeypatch):
    monkeypatch.setattr(axis_node, "MOVING_PERIOD_S", 0.0)
    homed.coordinates.clear()
    homed.move(FAR_MM)
    # At each step, and at the end; the owner is who moves it.
    shown = [(one.moving, one.owner) for one in homed.coordinates]
    assert shown == [(True, CONTROL)] * 2000 + [(False, "")]
    homed.tick()
    assert len(homed.coordinates) == 2002
    homed.in_motion(homed.tick)
    monkeypatch.setattr(axis_node, "MOVING_PERIOD_S", 60.0)
    homed.move(0.0)
    # That of the end, and no other one.
    assert len(homed.coordinates) == 2003


def test_the_endstop_is_shown_with_every_touch_of_it(homed):
    lamps = homed.graph.published["endstop"]
    lamps.clear()
    for _tick in range(3):
        homed.tick()
    # The switch was closed for a few milliseconds only.
    assert lamps == [True, False, False]
    homed.axis.machine.stuck = True
    assert fault_of(homed.call("homing")) == ENDSTOP.code
    homed.tick()
    assert lamps[-1] is True


def test_late_pulses_and_refused_scheduling_are_warnings(homed):
    homed.in_motion(lambda: 0.01)
    homed.move(FAR_MM)
    level, message, values = homed.health()
    assert (level, message.fault_code) == (WARN, OVERLOADED.as_warning().code)
    assert values["edges that slowed it down"] == 1
    refused = NOT_SET_UP.as_warning()
    homed.axis.pulses.scheduling = Message("refused").with_fault(refused)
    assert (homed.health()[0], homed.health()[1].fault_code) == (WARN, refused.code)


@pytest.mark.needs("socket filters")
def test_a_client_is_gone_when_its_connection_is_silent_for_too_long_or_closed():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        theirs = socket.create_connection(listener.getsockname())
        ours, _address = listener.accept()
    is_gone = watch([ours], 0.5)
    vanish(theirs)
    wait_until(is_gone)
    come_back(theirs)
    wait_until(lambda: not is_gone())
    theirs.close()
    wait_until(is_gone)
    ours.close()
    assert is_gone() and watch([], 60.0)()


def test_goals_that_ended_do_not_fill_the_status():
    ended, active = sorted(ENDED), max(ENDED) + 1
    states = [*ended[:4], active, *ended, *ended]
    listed = [SimpleNamespace(status=SimpleNamespace(status=state)) for state in states]
    server = GoalServer.__new__(GoalServer)
    server.action_server = SimpleNamespace(status_list=listed)
    server._forget_old_goals()
    assert [one.status.status for one in listed] == [active, *ended[-LISTED_GOALS:]]


def test_a_configured_controller_moves_the_axis_and_a_call_that_does_not_return_ends_the_process(
    monkeypatch,
):
    graph, ends, go_on = Graph(monkeypatch), [], threading.Event()
    monkeypatch.setattr(controller, "CALL_LIMIT_S", 0.0)
    monkeypatch.setattr(controller, "load_extension", lambda *_given: lambda _axis: go_on.wait(60))
    monkeypatch.setattr(axis_node.os, "_exit", ends.append)
    parameters = dataclasses.replace(SHORT, controller="a:B")

    def build():
        with contextlib.suppress(AxisException):
            axis_node.build_robot_axis(AxisId.X, parameters)

    threading.Thread(target=build).start()
    wait_until(lambda: graph.ticks and (graph.ticks[-1](), ends)[1])
    go_on.set()
    assert set(ends) == {1}
