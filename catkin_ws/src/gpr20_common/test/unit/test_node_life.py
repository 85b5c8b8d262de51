"""How the nodes of the robot begin, fail and end."""

import os
import signal
import threading
from types import SimpleNamespace

import pytest
from case_kit import each_case

from gpr20_common.errors import InvalidValueError, NodeSilentError
from gpr20_common.faults import INTERNAL
from gpr20_common.low.thread_fault import LOGGER, end_with_thread, faults_logged
from gpr20_common.message import Message

pytest.importorskip("rospy")

from gpr20_common.high import diagnostics, node

LIMIT_S = 100.0

LAUNCH = 4711


class Probe:
    """Finds no other node of the name, or one that lives."""

    other = False

    def __init__(self, *_arguments):
        pass

    def process(self):
        if not self.other:
            raise NodeSilentError(Message("nobody"))
        return 12


@pytest.fixture
def ended(monkeypatch):
    """The launches that a node has ended; each node here is the first of a launch."""
    found = []
    for name in ("init_node", "logfatal", "get_name"):
        monkeypatch.setattr(node.rospy, name, lambda *_all, **_named: "/node")
    # The node sets another one.
    monkeypatch.setattr(node.threading, "excepthook", node.threading.excepthook)
    monkeypatch.setattr(node.rospy, "has_param", lambda _name: False)
    monkeypatch.setattr(node, "configuration_name", lambda: "/launch_1")
    monkeypatch.setattr(node, "GraphKeeper", lambda: None)
    monkeypatch.setattr(node, "enable_line_buffering", lambda: None)
    monkeypatch.setattr(node, "roslaunch_number", lambda: LAUNCH)
    monkeypatch.setattr(node, "end_with_roslaunch", found.append)
    monkeypatch.setattr(node, "NodeProbe", Probe)
    return found


def refuse():
    raise InvalidValueError(Message("the port is taken"))


@each_case("other", [False, True])
@each_case("needed, launches", [(True, [LAUNCH]), (False, [])])
def test_only_a_node_that_is_needed_ends_its_launch(ended, monkeypatch, other, needed, launches):
    monkeypatch.setattr(Probe, "other", other)
    ended.clear()
    with pytest.raises(SystemExit) as status:
        node.run_node("node", refuse, needed)
    assert status.value.code == 1
    assert ended == launches


def fail():
    raise ZeroDivisionError("a fault of our own")


@pytest.fixture
def signals(monkeypatch):
    """The signals that this process would have got."""
    found = []
    monkeypatch.setattr(os, "kill", lambda number, one: found.append((number, one)))
    monkeypatch.setattr(threading, "excepthook", end_with_thread)
    return found


@pytest.fixture
def said(monkeypatch):
    """Return what the diagnostics of a node say: level and values, without their thread."""
    found = SimpleNamespace(setHardwareID=print, force_update=print)
    found.add = lambda _name, fill: setattr(found, "fill", fill)
    monkeypatch.setattr(diagnostics.diagnostic_updater, "Updater", lambda: found)
    monkeypatch.setattr(diagnostics, "Periodic", lambda *_all: None)
    monkeypatch.setattr(diagnostics.rospy, "on_shutdown", lambda _call: None)
    handlers = list(LOGGER.handlers)

    def ask(health):
        if health is not None:
            diagnostics.Diagnostics("hardware", health)
        values = {}
        status = SimpleNamespace(add=values.__setitem__)
        status.summary = lambda level, _text: setattr(status, "level", level)
        found.fill(status)
        return status.level, values

    yield ask
    LOGGER.handlers[:] = handlers


def run(target):
    thread = threading.Thread(target=target, name="worker")
    thread.start()
    thread.join(LIMIT_S)


def test_a_node_ends_in_order_with_a_thread_of_its_own(signals, fault_log):
    own = {**globals(), "__name__": "gpr20_axis_driver.mid.axis_driver"}
    run(type(fail)(fail.__code__, own))
    assert signals == [(os.getpid(), signal.SIGTERM)]
    for said in ("worker", "Traceback", "a fault of our own"):
        assert said in "".join(fault_log)


def test_what_was_logged_is_a_fault_of_the_diagnostics_for_a_while(said, monkeypatch):
    assert said(lambda: (diagnostics.OK, Message("fine"), {"free": 1}))[0] == diagnostics.OK
    with faults_logged("storage queue"):
        fail()
    level, values = said(None)
    assert level == diagnostics.ERROR and INTERNAL.code in values[diagnostics.FAULT]
    assert values["free"] == "1" and "storage queue" in values[diagnostics.FAULT]
    monkeypatch.setattr(diagnostics, "FAULT_S", 0.0)
    assert said(None)[0] == diagnostics.OK
