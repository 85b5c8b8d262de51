"""The processes beside this one, and what they do."""

import ctypes
import glob
import os
import signal
import subprocess
import sys
import time

import pytest
from case_kit import each_case

from gpr20_launch.low.sibling_nodes import SiblingNodes, is_traced, is_working

PTRACE_ATTACH, PTRACE_DETACH = 16, 17
WORD = "configuration:=/launch_1"
SLEEP = "import time; print(flush=True); time.sleep(60)"
SPIN = "print(flush=True)\nwhile True: pass"


@pytest.fixture
def start():
    begun = []

    def start(*words, program=SLEEP, namespace="/"):
        environment = {**os.environ, "ROS_NAMESPACE": namespace}
        process = subprocess.Popen(
            [sys.executable, "-c", program, *words], stdout=subprocess.PIPE, env=environment
        )
        begun.append(process)
        assert process.stdout.readline()
        return process

    yield start
    for process in begun:
        process.kill()
        process.communicate()


def nodes(parent=None):
    return SiblingNodes(os.getpid() if parent is None else parent, WORD, ["/window"])


def test_the_nodes_of_this_launch_are_found_by_their_full_names(start):
    storage = start(WORD, "__name:=storage")
    axis = start(WORD, "__name:=axis_driver", namespace="/robot1/x_axis")
    window = start("__name:=window")
    start("__name:=rosbag")
    start("configuration:=/launch_2", "__name:=storage")
    start(WORD)
    assert nodes().find() == {
        storage.pid: "/storage",
        axis.pid: "/robot1/x_axis/axis_driver",
        window.pid: "/window",
    }
    assert nodes(parent=1).find() == {}


def test_only_the_process_that_is_the_node_is_killed(start):
    storage = start(WORD, "__name:=storage")
    nodes(parent=1).kill(storage.pid, "/storage")
    nodes().kill(storage.pid, "/control")
    assert storage.poll() is None
    nodes().kill(storage.pid, "/storage")
    assert storage.wait(10.0) == -signal.SIGKILL
    nodes().kill(storage.pid, "/storage")


@each_case(
    "program, number, working", [(SLEEP, None, False), (SPIN, None, True), (SPIN, 19, False)]
)
def test_a_process_that_waits_or_is_halted_does_not_work(start, program, number, working):
    process = start(program=program)
    if number is not None:
        process.send_signal(number)
    deadline_s = time.monotonic() + 10.0
    while is_working(process.pid) is not working:
        assert time.monotonic() < deadline_s
        time.sleep(0.01)


def test_a_process_that_has_ended_does_nothing_and_can_be_killed(start, monkeypatch):
    process = start(WORD, "__name:=storage")
    others = nodes()
    process.kill()
    process.wait()
    # It ended after it was looked at.
    monkeypatch.setattr(others, "_name", lambda _number: "/storage")
    others.kill(process.pid, "/storage")
    assert not is_traced(process.pid)
    assert not is_working(process.pid)


def test_a_thread_that_ends_while_it_is_looked_at_hides_no_other(start, monkeypatch):
    process = start(program=SPIN)
    listed = glob.glob
    ended = f"/proc/{process.pid}/task/0/stat"
    monkeypatch.setattr(glob, "glob", lambda pattern: [ended, *listed(pattern)])
    deadline_s = time.monotonic() + 10.0
    while not is_working(process.pid):
        assert time.monotonic() < deadline_s


def test_only_a_process_under_a_debugger_is_traced(start):
    process = start()
    assert not is_traced(process.pid)
    # As gdb does; this process is its parent, so it may.
    ptrace = ctypes.CDLL(None).ptrace
    assert ptrace(PTRACE_ATTACH, process.pid, None, None) == 0
    os.waitpid(process.pid, 0)
    traced = is_traced(process.pid)
    assert ptrace(PTRACE_DETACH, process.pid, None, None) == 0
    assert traced
    assert not is_traced(process.pid)
