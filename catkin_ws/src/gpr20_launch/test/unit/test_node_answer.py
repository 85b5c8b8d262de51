"""Whether a process on this computer answers: what counts as silence."""

import contextlib
import os
import socket
import threading
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from case_kit import each_case

from gpr20_launch.low import node_answer
from gpr20_launch.low.node_answer import Answer, NodeAnswer

LIMIT_S = 0.3
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
    return NodeAnswer(master.uri, NAME, os.getpid() if number is None else number, LIMIT_S)


def test_a_node_that_hangs_after_an_answer_is_silent_and_alive_again_when_it_wakes(master, node):
    answer = asked(master)
    assert answer.ask() is Answer.ALIVE
    node.running.clear()
    assert [answer.ask() for _ in range(3)] == [Answer.SILENT] * 3
    node.running.set()
    assert answer.ask() is Answer.ALIVE


def test_a_node_that_hung_before_it_was_asked_is_mute_until_it_answers(master, node):
    node.running.clear()
    answer = asked(master)
    assert [answer.ask() for _ in range(2)] == [Answer.MUTE] * 2
    node.running.set()
    assert answer.ask() is Answer.ALIVE


def test_a_node_that_hangs_before_it_has_registered_is_mute(master, node, monkeypatch):
    # The master has the address of the process before it, where nobody listens any more.
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        node.uri = f"http://127.0.0.1:{free.getsockname()[1]}/"
    assert asked(master).ask() is Answer.MUTE
    monkeypatch.setattr(node_answer, "_is_own", lambda _host: False)
    assert asked(master).ask() is Answer.UNKNOWN


def test_a_node_that_never_answered_at_an_address_that_this_computer_lost_is_unknown(
    master, node, monkeypatch
):
    node.running.clear()
    monkeypatch.setattr(node_answer, "_is_own", lambda host: host != "127.0.0.1")
    assert asked(master).ask() is Answer.UNKNOWN


def test_a_master_that_hangs_says_nothing_about_a_node(master, node):
    unasked, answer = asked(master), asked(master)
    assert answer.ask() is Answer.ALIVE
    master.running.clear()
    assert unasked.ask() is Answer.UNKNOWN
    assert answer.ask() is Answer.ALIVE
    node.running.clear()
    assert answer.ask() is Answer.SILENT


def test_another_process_under_the_same_name_is_not_the_node(master, node):
    assert asked(master, number=1).ask() is Answer.UNKNOWN


def test_a_node_that_refuses_connections_is_ending(master, node):
    answer = asked(master)
    assert answer.ask() is Answer.ALIVE
    # As a new process has it: nothing is left of the connection.
    answer._confirmed.close()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        answer._confirmed._address = free.getsockname()
    assert answer.ask() is Answer.UNKNOWN


@each_case("host", ["192.0.2.1", "no-such-host.invalid"])
def test_an_address_that_this_computer_lost_says_nothing_about_a_node(master, node, host):
    answer = asked(master)
    assert answer.ask() is Answer.ALIVE
    node.running.clear()
    answer._host = host
    assert answer.ask() is Answer.UNKNOWN
    node.running.set()
