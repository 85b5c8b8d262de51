"""Which nodes the watchdog ends: what counts as silence, and what it reports to systemd."""

import contextlib
import os
import socket
from unittest import mock

import pytest
from case_kit import each_case
from robot_kit import RpcServer

from gpr20_common.low.links import limited_server
from gpr20_doctor.low.masters import is_here
from gpr20_launch.low import launched_nodes
from gpr20_launch.low.launched_nodes import LaunchedNodes
from gpr20_launch.mid.watchdog import PERIOD_S, STALL_S, Watchdog

LIMIT_S = 10.0
STORAGE, CONTROL = 11, 12
ALIVE, SILENT, UNKNOWN = True, False, None


class Robot:
    """Two nodes and a watchdog; a request to a silent node takes as long as it may."""

    def __init__(self):
        self.now = 0.0
        self.found = {STORAGE: "/vna_processing", CONTROL: "/main_control"}
        self.said = {STORAGE: ALIVE, CONTROL: ALIVE}
        self.working = set()
        self.killed = []
        self.watchdog = Watchdog(self, LIMIT_S, self, lambda line: None)

    def now_s(self):
        return self.now

    def find(self):
        return dict(self.found)

    def answers(self, number, name):
        assert self.found[number] == name
        answer = self.said[number]
        self.now += 2.0 if answer is SILENT else 0.0
        return answer

    def is_working(self, number):
        return number in self.working

    def kill(self, number, name):
        self.killed.append((self.now, name))
        del self.found[number]

    def run(self, duration_s):
        end_s = self.now + duration_s
        while self.now < end_s:
            self.watchdog.look()
            self.now += PERIOD_S


@pytest.fixture
def robot():
    robot = Robot()
    robot.run(4.0)
    return robot


def test_a_node_that_answers_nothing_is_ended_after_the_limit_and_no_other(robot):
    begun_s = robot.now
    robot.said[STORAGE] = SILENT
    robot.run(60.0)
    ((ended_s, name),) = robot.killed
    assert name == "/vna_processing"
    assert LIMIT_S <= ended_s - begun_s <= LIMIT_S + 2 * PERIOD_S


@each_case("answer", [ALIVE, UNKNOWN])
def test_one_answer_or_one_doubt_begins_the_time_again(answer):
    robot = Robot()
    for _ in range(20):
        robot.said[STORAGE] = SILENT
        robot.run(LIMIT_S - 3.0)
        robot.said[STORAGE] = answer
        robot.run(PERIOD_S)
    assert robot.killed == []


def test_a_node_that_worked_in_its_silence_gets_longer_and_is_ended_in_the_end(robot):
    begun_s = robot.now
    robot.said[STORAGE] = SILENT
    robot.working.add(STORAGE)
    robot.run(3.0)
    robot.working.clear()
    robot.run(2.0 * LIMIT_S)
    robot.working.add(STORAGE)
    robot.run(2.5 * LIMIT_S)
    assert robot.killed == []
    robot.run(2.0 * LIMIT_S)
    assert robot.killed[0][0] - begun_s == pytest.approx(6.0 * LIMIT_S, abs=2 * PERIOD_S)


def test_a_computer_that_was_held_up_ends_nobody_for_it(robot):
    robot.said = {STORAGE: SILENT, CONTROL: SILENT}
    robot.run(4.0)
    robot.now += STALL_S + 100.0
    robot.run(4.0)
    robot.said = {STORAGE: ALIVE, CONTROL: ALIVE}
    robot.run(60.0)
    assert robot.killed == []


def test_a_node_that_took_the_place_of_another_begins_with_no_silence(robot):
    robot.said[STORAGE] = SILENT
    robot.run(6.0)
    robot.found[13] = robot.found.pop(STORAGE)
    robot.said[13] = SILENT
    robot.run(6.0)
    assert robot.killed == []


ANSWER_LIMIT_S = 2.0
NAME = "/storage"


@pytest.fixture
def node():
    with contextlib.closing(RpcServer(getPid=lambda _caller: (1, "", os.getpid()))) as server:
        yield server


@pytest.fixture
def master(node):
    with contextlib.closing(
        RpcServer(lookupNode=lambda _caller, _name: (1, "", node.uri))
    ) as server:
        yield server


def asked(master, number=None):
    """Return a function that asks the node, as the watchdog does in each round."""
    nodes = LaunchedNodes(1, "", (), master.uri, ANSWER_LIMIT_S)
    own = os.getpid() if number is None else number
    return lambda: nodes.answers(own, NAME)


def test_a_node_is_silent_only_after_its_first_answer(master, node):
    node.running.clear()
    answer = asked(master)
    assert answer() is UNKNOWN
    node.running.set()
    assert answer() is ALIVE
    node.running.clear()
    assert [answer() for _ in range(2)] == [SILENT] * 2
    node.running.set()
    assert answer() is ALIVE


def test_a_master_that_hangs_says_nothing_about_a_node(master, node):
    unasked, answer = asked(master), asked(master)
    assert answer() is ALIVE
    master.running.clear()
    assert unasked() is UNKNOWN and answer() is ALIVE
    node.running.clear()
    assert answer() is SILENT


def test_a_refusal_a_lost_address_and_another_process_of_the_name_say_nothing(
    master, node, monkeypatch
):
    assert asked(master, number=1)() is UNKNOWN
    answer = asked(master)
    assert answer() is ALIVE
    node.running.clear()
    with monkeypatch.context() as lost:
        lost.setattr(launched_nodes, "is_here", lambda _host: False)
        assert answer() is UNKNOWN
    assert not is_here("192.0.2.1") and not is_here("no-such-host.invalid")
    node.running.set()
    # It is ending: nothing listens at its address.
    nodes = LaunchedNodes(1, "", (), master.uri, ANSWER_LIMIT_S)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        uri = f"http://127.0.0.1:{free.getsockname()[1]}/"
        nodes._confirmed[1, NAME] = uri, limited_server(uri, ANSWER_LIMIT_S)
        assert nodes.answers(1, NAME) is UNKNOWN


@pytest.fixture
def systemd(monkeypatch):
    """Return a systemd's socket, whose abstract address its services are given."""
    # Linux allows 108 bytes: the folder of a test may be longer.
    monkeypatch.setenv("NOTIFY_SOCKET", f"@gpr20_test_notify_{os.getpid()}")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.settimeout(100.0)
        listener.bind(f"\0gpr20_test_notify_{os.getpid()}")
        yield listener


def test_systemd_guards_until_the_launch_has_ended_and_on_after_an_error(monkeypatch, systemd):
    watchdog = pytest.importorskip("gpr20_launch.high.watchdog")
    fake = mock.Mock(is_launch=True)
    for name in ("process_of", "Watchdog"):
        monkeypatch.setattr(watchdog, name, lambda *_all: fake)
    monkeypatch.setattr(watchdog.rosgraph, "myargv", lambda: ["", "--launch=/l", "--limit=9"])
    monkeypatch.setattr(watchdog.signal, "signal", lambda *_all: None)
    monkeypatch.setattr(watchdog, "enable_line_buffering", lambda: None)
    monkeypatch.setattr(watchdog, "PERIOD_S", 0.0)
    fake.look.side_effect = [None, ZeroDivisionError()]
    with pytest.raises(ZeroDivisionError):
        watchdog.main()
    fake.look.side_effect = lambda: monkeypatch.setattr(os, "getppid", lambda: 1)
    assert watchdog.main() == 0
    alive, released = b"WATCHDOG=1\nWATCHDOG_USEC=60000000", b"WATCHDOG_USEC=0"
    assert [systemd.recv(200) for _ in range(3)] == [alive, alive, released]
