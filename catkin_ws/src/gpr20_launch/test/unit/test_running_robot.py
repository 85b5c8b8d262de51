"""Who runs beside a launch, what they do, and the modules without which nothing is launched."""

from __future__ import annotations

import ctypes
import glob
import os
import signal
import subprocess
import sys
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from case_kit import each_case
from wait_kit import wait_until

from gpr20_launch.low import needed_modules
from gpr20_launch.low.needed_modules import what_to_install
from gpr20_launch.low.process_info import ProcessInfo, process_info
from gpr20_launch.low.sibling_nodes import SiblingNodes, is_traced, is_working
from gpr20_launch.mid.running_robot import RunningNode, refusal

LAUNCH = ProcessInfo(70, 1, ("/usr/bin/python3", "/usr/bin/roslaunch", "gpr20"), datetime.now())
SHELL = ProcessInfo(1, 0, ("/sbin/init",), datetime.now())


def node(number, parent):
    process = ProcessInfo(
        number, parent.number if parent else 1, ("python3",), datetime(2026, 11, 22, 7, 0, number)
    )
    return RunningNode(f"/node{number}", number, process, parent)


def test_nodes_that_run_are_ended_by_one_command():
    here = "http://localhost:11311"
    said = str(refusal([node(12, LAUNCH), node(11, LAUNCH)], here))
    assert "since 2026-11-22 07:00:11" in said
    assert "/node12 (process 12), /node11 (process 11)" in said
    assert "kill -INT 70." in said
    assert "ns:=robot2" in said
    # The launch of some was killed.
    assert str(refusal([node(11, SHELL), node(12, None)], here)).endswith("kill 11 12")
    assert str(refusal([node(11, SHELL), node(12, LAUNCH)], here)).endswith("kill 70 11")
    said = str(refusal([replace(node(11, None), process=None)], "http://10.20.0.2:11311"))
    assert "on http://10.20.0.2:11311: /node11" in said
    assert "end it there" in said and "kill" not in said


def test_a_node_is_recognized_by_its_command_line():
    launched = replace(SHELL, command=("python3", "/lib/simulated_axis_driver", "__name:=axis"))
    alone = replace(SHELL, command=("python3", "/lib/gpr20_vna_processing/vna_processing"))
    assert launched.may_be_node("/x_axis/axis")
    assert not launched.may_be_node("/y_axis/other")
    assert alone.may_be_node("/robot1/vna_processing")
    assert not SHELL.may_be_node("/vna_processing")


def test_a_process_is_described_as_the_system_knows_it():
    before = datetime.now()
    program = [sys.executable, "-c", "print(flush=True); input()"]
    with subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as child:
        # The command line of a process is empty for a moment after its start.
        assert child.stdout is not None and child.stdout.readline()
        found = process_info(child.pid)
        assert found is not None
        assert found.parent == os.getpid()
        assert found.command == tuple(program)
        # The start is counted in ticks since a boot that is known to a second.
        close = timedelta(seconds=3)
        assert before - close < found.started < datetime.now() + close
        assert not found.is_roslaunch
    wait_until(lambda: process_info(child.pid) is None)


CHECK = Path(__file__).resolve().parents[2] / "nodes" / "check_launch"
SOURCES = Path(__file__).resolve().parents[2] / "src"


def test_what_is_missing_is_named_with_the_commands_that_install_it(monkeypatch):
    assert what_to_install(lambda module: True) is None
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    missing = {"actionlib_msgs", "yaml", "vxi11", "mcap"}
    said = what_to_install(lambda module: module not in missing)
    assert f"{sys.executable} (Python 3." in said
    assert "lacks the modules actionlib_msgs, yaml, mcap, vxi11." in said
    assert "sudo apt-get install python3-actionlib-msgs python3-yaml\n" in said
    assert "python3 -m pip install mcap python-vxi11\n" in said
    # Packages of ROS have the names of the ROS that was sourced.
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"/home/user/install:{needed_modules.NOETIC}")
    said = what_to_install(lambda module: module != "diagnostic_updater")
    assert "sudo apt-get install ros-noetic-diagnostic-updater\n" in said
    assert "pip" not in said


def test_a_launch_without_them_is_refused_with_one_text_and_no_traceback():
    ended = subprocess.run(
        # Neither the packages of the system nor those of an environment.
        [sys.executable, "-S", str(CHECK)],
        env={"PYTHONPATH": str(SOURCES)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 1
    assert "This robot cannot be launched: " in ended.stderr
    assert "lacks the modules actionlib, " in ended.stderr
    assert "Traceback" not in ended.stderr


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
    assert storage.wait() == -signal.SIGKILL
    nodes().kill(storage.pid, "/storage")


@each_case(
    "program, number, working", [(SLEEP, None, False), (SPIN, None, True), (SPIN, 19, False)]
)
def test_a_process_that_waits_or_is_halted_does_not_work(start, program, number, working):
    process = start(program=program)
    if number is not None:
        process.send_signal(number)
    wait_until(lambda: is_working(process.pid) is working)


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
    wait_until(lambda: is_working(process.pid))


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
