"""An exception that nobody expected in a thread is logged, said, and never silent."""

import os
import signal
import threading

import pytest

pytest.importorskip("rospy")

from gpr20_common.faults import INTERNAL
from gpr20_common.high import diagnostics
from gpr20_common.low.thread_fault import LOGGER, end_with_thread, faults_logged
from gpr20_common.message import Message

LIMIT_S = 10.0


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
def node(monkeypatch):
    """The diagnostics of a node, without their thread."""
    monkeypatch.setattr(diagnostics.diagnostic_updater, "Updater", Updater)
    monkeypatch.setattr(diagnostics, "Periodic", lambda *_all: None)
    monkeypatch.setattr(diagnostics.rospy, "on_shutdown", lambda _call: None)
    handlers = list(LOGGER.handlers)
    yield diagnostics.Diagnostics
    LOGGER.handlers[:] = handlers


class Updater:
    def setHardwareID(self, _name):  # noqa: N802 (of diagnostic_updater)
        pass

    def add(self, _name, fill):
        Updater.fill = fill

    def force_update(self):
        pass


class Status(dict):
    def summary(self, level, text):
        self.level = level

    def add(self, name, value):
        self[name] = value


def said():
    return Updater.fill(Status())


def run(target):
    thread = threading.Thread(target=target, name="worker")
    thread.start()
    thread.join(LIMIT_S)


def test_a_node_ends_in_order_with_a_thread_of_its_own(signals, fault_log):
    own = {**globals(), "__name__": "gpr20_axis_driver.mid.axis_driver"}
    run(type(fail)(fail.__code__, own))
    assert signals == [(os.getpid(), signal.SIGTERM)]
    assert "worker" in "".join(fault_log)
    assert "Traceback" in "".join(fault_log)
    assert "a fault of our own" in "".join(fault_log)


def test_the_thread_of_a_library_is_logged_alone(signals, fault_log):
    run(fail)
    assert signals == []
    assert "a fault of our own" in "".join(fault_log)


def test_what_was_logged_is_a_fault_of_the_diagnostics_for_a_while(node, monkeypatch):
    node("hardware", lambda: (diagnostics.OK, Message("fine"), {"free": 1}))
    assert said().level == diagnostics.OK
    with faults_logged("storage queue"):
        fail()
    now = said()
    assert (now.level, now[diagnostics.FAULT_CODE]) == (diagnostics.ERROR, INTERNAL.code)
    assert now["free"] == "1"
    assert "storage queue" in now[diagnostics.MESSAGE_JSON]
    monkeypatch.setattr(diagnostics, "FAULT_S", 0.0)
    assert said().level == diagnostics.OK


def test_diagnostics_that_fail_are_a_fault(node):
    node("hardware", fail)
    now = said()
    assert (now.level, now[diagnostics.FAULT_CODE]) == (diagnostics.ERROR, INTERNAL.code)
