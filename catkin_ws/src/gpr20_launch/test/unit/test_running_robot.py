"""Who runs beside a launch, what they do, and the modules without which nothing is launched."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
from case_kit import each_case
from wait_kit import wait_until

from gpr20_doctor.low.processes import Process, process_of
from gpr20_launch.low import launched_nodes
from gpr20_launch.low.launched_nodes import LaunchedNodes


def test_a_node_is_recognized_by_its_command_line():
    may_be = pytest.importorskip("gpr20_launch.high.check_launch").may_be
    launched = Process(8, 1, ("python3", "/lib/simulated_axis_driver", "__name:=axis"))
    alone = Process(9, 1, ("python3", "/lib/gpr20_vna_processing/vna_processing"))
    assert may_be(launched, "/x_axis/axis") and not may_be(launched, "/y_axis/other")
    assert may_be(alone, "/robot1/vna_processing")
    assert not may_be(Process(1, 0, ("/sbin/init",)), "/vna_processing")


def test_a_launch_without_a_module_is_refused_with_what_installs_it(tmp_path, monkeypatch, run):
    program = Path(__file__).resolve().parents[2] / "nodes/check_launch"
    (tmp_path / "rosgraph.py").write_text("raise ModuleNotFoundError(name='rosgraph')")
    path = os.pathsep.join([str(tmp_path), *sys.path])
    command = [sys.executable, str(program), "--help"]
    ended = subprocess.run(command, env={"PYTHONPATH": path}, stderr=subprocess.PIPE, text=True)
    said = "This robot cannot be launched: the Python module rosgraph is missing; "
    assert (ended.returncode, ended.stderr.strip()) == (1, f"{said}run: scripts/setup.sh")
    check_launch = pytest.importorskip("gpr20_launch.high.check_launch")
    monkeypatch.setattr(check_launch, "NEEDED", ["sys", "no_such_module"])
    status, printed, said = run("check_launch", "--part", "robot", "--robot", "gpr20")
    assert (status, printed) == (1, "")
    assert "the Python modules no_such_module are missing; run: scripts/setup.sh" in said


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
    own = os.getpid() if parent is None else parent
    return LaunchedNodes(own, WORD, ["/window"], "http://localhost:9", 2.0)


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


def test_only_the_process_that_is_the_node_is_killed(start, monkeypatch):
    storage, killed = start(WORD, "__name:=storage"), []
    with monkeypatch.context() as noted:
        noted.setattr(launched_nodes.os, "kill", lambda *given: killed.append(given))
        nodes(parent=1).kill(storage.pid, "/storage")
        nodes().kill(storage.pid, "/control")
    assert not killed
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
    wait_until(lambda: nodes().is_working(process.pid) is working)


def test_a_process_that_has_ended_does_nothing_and_can_be_killed(start, monkeypatch):
    process = start(WORD, "__name:=storage")
    found, others = process_of(process.pid), nodes()
    assert found.parent == os.getpid() and found.words[0] == sys.executable
    created_s = psutil.Process(process.pid).create_time()
    assert found.started_s == pytest.approx(created_s, abs=2.0)
    process.kill()
    process.wait()
    assert process_of(process.pid) is None and not nodes().is_working(process.pid)
    # It ended after it was looked at.
    monkeypatch.setattr(launched_nodes, "process_of", lambda _number: found)
    others.kill(process.pid, "/storage")
