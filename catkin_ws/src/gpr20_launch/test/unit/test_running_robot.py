"""Who runs already, since when, and the command that ends them."""

import os
import subprocess
import sys
import time
from dataclasses import replace
from datetime import datetime

from gpr20_launch.low.process_info import ProcessInfo, process_info
from gpr20_launch.mid.running_robot import RunningNode, refusal

LAUNCH = ProcessInfo(70, 1, ("/usr/bin/python3", "/usr/bin/roslaunch", "gpr20"), datetime.now())
SHELL = ProcessInfo(1, 0, ("/sbin/init",), datetime.now())


def node(number, parent):
    process = ProcessInfo(
        number, parent.number if parent else 1, ("python3",), datetime(2026, 11, 22, 7, 0, number)
    )
    return RunningNode(f"/node{number}", number, process, parent)


def test_a_launch_that_lives_is_ended_by_one_command():
    said = str(refusal([node(12, LAUNCH), node(11, LAUNCH)], "http://localhost:11311"))
    assert "since 2026-11-22 07:00:11" in said
    assert "/node12 (process 12), /node11 (process 11)" in said
    assert "kill -INT 70." in said
    assert "ns:=robot2" in said


def test_nodes_whose_launch_was_killed_are_ended_by_one_command():
    said = str(refusal([node(11, SHELL), node(12, None)], "http://localhost:11311"))
    assert said.endswith("kill 11 12")


def test_nodes_of_both_kinds_are_ended_by_one_command():
    said = str(refusal([node(11, SHELL), node(12, LAUNCH)], "http://localhost:11311"))
    assert said.endswith("kill 70 11")


def test_nodes_of_another_computer_are_ended_there():
    elsewhere = replace(node(11, None), process=None)
    said = str(refusal([elsewhere], "http://10.20.0.2:11311"))
    assert "on http://10.20.0.2:11311: /node11" in said
    assert "end it there" in said
    assert "kill" not in said


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
        assert abs((found.started - before).total_seconds()) < 3.0
        assert not found.is_roslaunch
    deadline_s = time.monotonic() + 10.0
    while process_info(child.pid) is not None and time.monotonic() < deadline_s:
        time.sleep(0.01)
    assert process_info(child.pid) is None
