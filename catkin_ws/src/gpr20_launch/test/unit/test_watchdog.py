"""Which nodes the watchdog ends: what counts as silence, and what it reports to systemd."""

import contextlib
import os
import socket
import threading
from unittest import mock
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from case_kit import each_case

from gpr20_common.low.links import limited_server
from gpr20_launch.low import node_answer
from gpr20_launch.low.node_answer import Answer, NodeAnswer
from gpr20_launch.mid.watchdog import (
    MUTE_LIMIT_S,
    PERIOD_S,
    RESPAWN_LIMIT_S,
    STALL_S,
    Watchdog,
)

LIMIT_S = 10.0
STORAGE, CONTROL = 11, 12
ALIVE, SILENT, MUTE, UNKNOWN = Answer.ALIVE, Answer.SILENT, Answer.MUTE, Answer.UNKNOWN


class Robot:
    """Two nodes and a watchdog; a request to a silent node takes as long as it may."""

    def __init__(self, *spared):
        self.now = 0.0
        self.found = {STORAGE: "/vna_processing", CONTROL: "/main_control"}
        self.answers = {STORAGE: ALIVE, CONTROL: ALIVE}
        self.working = set()
        self.traced = set()
        self.killed = []
        self.watchdog = Watchdog(self, LIMIT_S, self, lambda line: None, spared)

    def now_s(self):
        return self.now

    def find(self):
        return dict(self.found)

    def ask(self, number, name):
        assert self.found[number] == name
        answer = self.answers[number]
        self.now += 2.0 if answer in (SILENT, MUTE) else 0.0
        return answer

    def is_working(self, number):
        return number in self.working

    def is_traced(self, number):
        return number in self.traced

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
    robot.answers[STORAGE] = SILENT
    robot.run(60.0)
    ((ended_s, name),) = robot.killed
    assert name == "/vna_processing"
    assert LIMIT_S <= ended_s - begun_s <= LIMIT_S + 2 * PERIOD_S


@each_case("answer", [ALIVE, UNKNOWN])
def test_one_answer_or_one_doubt_begins_the_time_again(answer):
    robot = Robot()
    for _ in range(20):
        robot.answers[STORAGE] = SILENT
        robot.run(LIMIT_S - 3.0)
        robot.answers[STORAGE] = answer
        robot.run(PERIOD_S)
    assert robot.killed == []


def test_a_node_that_has_never_answered_is_ended_after_a_minute_unless_it_computes_or_is_traced():
    robot = Robot()
    robot.answers[STORAGE] = MUTE
    for busy in (robot.working, robot.traced):
        busy.add(STORAGE)
        robot.run(20.0 * MUTE_LIMIT_S)
        busy.clear()
    assert robot.killed == []
    robot = Robot()
    robot.answers = {STORAGE: MUTE, CONTROL: UNKNOWN}
    robot.run(MUTE_LIMIT_S - PERIOD_S)
    assert robot.killed == []
    robot.run(600.0)
    # What cannot be asked is never ended.
    assert [name for _at_s, name in robot.killed] == ["/vna_processing"]


def test_a_node_that_worked_in_its_silence_gets_longer_and_is_ended_in_the_end(robot):
    begun_s = robot.now
    robot.answers[STORAGE] = SILENT
    robot.working.add(STORAGE)
    robot.run(3.0)
    robot.working.clear()
    robot.run(2.0 * LIMIT_S)
    robot.working.add(STORAGE)
    robot.run(2.5 * LIMIT_S)
    assert robot.killed == []
    robot.run(2.0 * LIMIT_S)
    assert robot.killed[0][0] - begun_s == pytest.approx(6.0 * LIMIT_S, abs=2 * PERIOD_S)


def test_a_node_under_a_debugger_is_left_alone_until_the_debugger_is_gone(robot):
    robot.answers[STORAGE] = SILENT
    robot.traced.add(STORAGE)
    robot.run(100.0)
    assert robot.killed == []
    robot.traced.clear()
    robot.run(10.0)
    assert [name for _at_s, name in robot.killed] == ["/vna_processing"]


def test_a_computer_that_was_held_up_ends_nobody_for_it(robot):
    robot.answers = {STORAGE: SILENT, CONTROL: SILENT}
    robot.run(4.0)
    robot.now += STALL_S + 100.0
    robot.run(4.0)
    robot.answers = {STORAGE: ALIVE, CONTROL: ALIVE}
    robot.run(60.0)
    assert robot.killed == []


def test_a_node_that_took_the_place_of_another_begins_with_no_silence(robot):
    robot.answers[STORAGE] = SILENT
    robot.run(6.0)
    robot.found[13] = robot.found.pop(STORAGE)
    robot.answers[13] = SILENT
    robot.run(6.0)
    assert robot.killed == []


def test_a_node_that_is_not_restarted_makes_the_launch_incomplete_unless_it_is_spared():
    robot = Robot("/vna_processing")
    robot.run(4.0)
    robot.answers[STORAGE] = SILENT
    robot.run(2.0 * RESPAWN_LIMIT_S)
    assert [name for _at_s, name in robot.killed] == ["/vna_processing"]
    name = robot.found.pop(CONTROL)
    robot.run(RESPAWN_LIMIT_S - PERIOD_S)
    assert robot.watchdog.complete
    robot.run(2 * PERIOD_S)
    assert not robot.watchdog.complete
    robot.found[13], robot.answers[13] = name, ALIVE
    robot.run(PERIOD_S)
    assert robot.watchdog.complete


ANSWER_LIMIT_S = 2.0
NAME = "/storage"


class Server(SimpleXMLRPCServer):
    """Answers in a thread of its own until it hangs."""

    def __init__(self, **methods):
        super().__init__(("127.0.0.1", 0), logRequests=False)
        self.running = threading.Event()
        self.running.set()
        for name, method in methods.items():
            self.register_function(self._when_running(method), name)
        self.uri = f"http://127.0.0.1:{self.server_address[1]}/"
        self.thread = threading.Thread(target=self.serve_forever, kwargs={"poll_interval": 0.01})
        self.thread.start()

    def _when_running(self, method):
        def answer(*arguments):
            self.running.wait()
            return method(*arguments)

        return answer

    def close(self):
        self.running.set()
        self.shutdown()
        self.thread.join()
        self.server_close()


@pytest.fixture
def node():
    with contextlib.closing(Server(getPid=lambda _caller: (1, "", os.getpid()))) as server:
        yield server


@pytest.fixture
def master(node):
    with contextlib.closing(Server(lookupNode=lambda _caller, _name: (1, "", node.uri))) as server:
        yield server


def asked(master, number=None):
    return NodeAnswer(master.uri, NAME, os.getpid() if number is None else number, ANSWER_LIMIT_S)


def test_a_node_that_hangs_is_mute_before_its_first_answer_and_silent_after_it(master, node):
    node.running.clear()
    answer = asked(master)
    assert [answer.ask() for _ in range(2)] == [Answer.MUTE] * 2
    node.running.set()
    assert answer.ask() is Answer.ALIVE
    node.running.clear()
    assert [answer.ask() for _ in range(2)] == [Answer.SILENT] * 2
    node.running.set()
    assert answer.ask() is Answer.ALIVE


def test_a_node_that_never_answered_is_mute_at_an_address_of_this_computer_alone(
    master, node, monkeypatch
):
    node.running.clear()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        # That of the process before it, where nobody listens any more.
        for uri in (node.uri, f"http://127.0.0.1:{free.getsockname()[1]}/"):
            node.uri = uri
            assert asked(master).ask() is Answer.MUTE
            with monkeypatch.context() as lost:
                lost.setattr(node_answer, "_is_own", lambda _host: False)
                assert asked(master).ask() is Answer.UNKNOWN


def test_a_master_that_hangs_says_nothing_about_a_node(master, node):
    unasked, answer = asked(master), asked(master)
    assert answer.ask() is Answer.ALIVE
    master.running.clear()
    assert unasked.ask() is Answer.UNKNOWN
    assert answer.ask() is Answer.ALIVE
    node.running.clear()
    assert answer.ask() is Answer.SILENT


def test_a_refusal_a_lost_address_and_another_process_of_the_name_say_nothing(master, node):
    assert asked(master, number=1).ask() is Answer.UNKNOWN
    answer = asked(master)
    assert answer.ask() is Answer.ALIVE
    node.running.clear()
    for host in ("192.0.2.1", "no-such-host.invalid"):
        answer._host = host
        assert answer.ask() is Answer.UNKNOWN
    node.running.set()
    # It is ending. As a new process has it: nothing is left of the connection.
    answer = asked(master)
    assert answer.ask() is Answer.ALIVE
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        uri = f"http://127.0.0.1:{free.getsockname()[1]}/"
        answer._confirmed = limited_server(uri, ANSWER_LIMIT_S)
    assert answer.ask() is Answer.UNKNOWN


@pytest.fixture(params=["path", "abstract"])
def systemd(request, tmp_path, monkeypatch):
    """Return a systemd's socket, whose address its services are given."""
    name, abstract = str(tmp_path / "notify"), request.param == "abstract"
    monkeypatch.setenv("NOTIFY_SOCKET", "@" + name[1:] if abstract else name)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.settimeout(100.0)
        listener.bind("\0" + name[1:] if abstract else name)
        yield listener


def test_systemd_guards_until_the_launch_has_ended_and_on_after_an_error(monkeypatch, systemd):
    watchdog = pytest.importorskip("gpr20_launch.high.watchdog")
    fake = mock.Mock(is_roslaunch=True, complete=True)
    for name in ("process_info", "Watchdog"):
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
