"""The query for a node's process against answers of every kind."""

import socket
import threading

import pytest
from case_kit import each_case

from gpr20_common.low.pid_query import PidQuery

LIMIT_S = 1.0


def answer(body, version="1.1", length=None):
    length = len(body) if length is None else length
    return f"HTTP/{version} 200 OK\r\nContent-length: {length}\r\n\r\n{body}".encode()


def pid_body(pid, code=1, kind="int"):
    values = f"<value><{kind}>{code}</{kind}></value><value><string></string></value>"
    return f"<data>{values}<value><{kind}>{pid}</{kind}></value></data>"


class Node:
    """Accepts connections one after another; sends one answer for each request, then closes.

    An answer is a list of its pieces.
    """

    def __init__(self, *connections):
        self.requests = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.uri = f"http://127.0.0.1:{self._listener.getsockname()[1]}/"
        self._thread = threading.Thread(target=self._serve, args=(connections,), daemon=True)
        self._thread.start()

    def _serve(self, connections):
        for answers in connections:
            accepted, _ = self._listener.accept()
            accepted.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with accepted:
                for parts in answers:
                    self.requests.append(accepted.recv(65536))
                    for part in parts:
                        accepted.sendall(part)
        self._listener.close()


@each_case("kind", ["int", "i4"])
def test_one_connection_serves_many_queries(kind):
    node = Node([[answer(pid_body(one, kind=kind))] for one in (4711, 4712, 4713)])
    query = PidQuery(node.uri, "/main<control", LIMIT_S)
    assert [query.ask() for _ in range(3)] == [4711, 4712, 4713]
    assert b"<string>/main&lt;control</string>" in node.requests[0]
    assert node.requests[0].startswith(b"POST / HTTP/1.1\r\n")
    query.close()


def test_a_connection_that_the_node_has_ended_is_made_again():
    node = Node([[answer(pid_body(1))]], [[answer(pid_body(2))]])
    query = PidQuery(node.uri, "/x", LIMIT_S)
    assert [query.ask(), query.ask()] == [1, 2]
    query.close()


def test_an_answer_may_come_in_pieces():
    whole = answer(pid_body(4711))
    node = Node([[bytes([one]) for one in whole]])
    query = PidQuery(node.uri, "/x", LIMIT_S)
    assert query.ask() == 4711
    query.close()


@each_case(
    "wrong",
    [
        answer(pid_body(5, code=-1)),
        answer("<fault><int>1</int></fault>"),
        answer(""),
        answer("<int>1</int><int>99999999999999</int>"),
        b"HTTP/1.1 200 OK\r\n\r\n",
        b"HTTP/1.1 200 OK\r\nContent-Length: many\r\n\r\n",
        b"x" * 200_000,
        answer("y" * 200_000),
    ],
)
def test_another_answer_is_an_error(wrong):
    query = PidQuery(Node([[wrong]]).uri, "/x", LIMIT_S)
    with pytest.raises((ValueError, OSError)):
        query.ask()


def test_a_node_that_closes_without_an_answer_does_not_answer():
    query = PidQuery(Node([[b"HTTP/1.1 200"]]).uri, "/x", LIMIT_S)
    with pytest.raises(ConnectionError):
        query.ask()


@each_case("uri", ["", "http://", "http://127.0.0.1/", "nothing"])
def test_an_address_without_host_or_port_is_refused(uri):
    with pytest.raises(ValueError, match="no host or no port"):
        PidQuery(uri, "/x", LIMIT_S)
