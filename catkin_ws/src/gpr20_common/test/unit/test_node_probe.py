"""Asking nodes over real sockets: alive, dead, hanging, unknown, restarted."""

import socket
import threading
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common import faults
from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.low.node_probe import NodeProbe
from gpr20_common.low.pid_query import PidQuery

LIMIT_S = 0.5
# What a node may take that lives.
PATIENT_S = 30.0


class Server:
    """An XML-RPC server in a thread, as a node or the master has one."""

    def __init__(self, **methods):
        self.server = SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        for name, method in methods.items():
            self.server.register_function(method, name)
        self.uri = f"http://127.0.0.1:{self.server.server_address[1]}/"
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()

    def close(self):
        self.server.shutdown()
        self.server.server_close()


class Graph:
    """A master that knows nodes."""

    def __init__(self):
        self.uris = {}
        self.master = Server(lookupNode=self._look_up)
        self.lookups = 0

    def _look_up(self, _caller, name):
        self.lookups += 1
        uri = self.uris.get(name)
        return (1, "", uri) if uri else (-1, f"unknown node [{name}]", "")

    def add(self, name, pid):
        node = Server(getPid=lambda _caller: (1, "", pid))
        self.uris[name] = node.uri
        return node

    def probe(self, name):
        return NodeProbe(self.master.uri, "/asker", name, LIMIT_S)


@pytest.fixture
def graph():
    graph = Graph()
    yield graph
    graph.master.close()


def test_a_node_that_lives_tells_its_process_and_is_not_silent_because_the_master_dies(graph):
    node = graph.add("/x", 4711)
    probe = graph.probe("/x")
    assert [probe.process() for _ in range(3)] == [4711, 4711, 4711]
    assert graph.lookups == 1
    graph.uris.clear()
    assert probe.process() == 4711
    node.close()


def test_a_node_that_the_master_does_not_know_is_silent(graph):
    with raises_fault(faults.NODE_GONE, "/x", "unknown node", error=NodeGoneError):
        graph.probe("/x").process()


@pytest.mark.parametrize("is_silent_first", [True, False])
def test_a_node_that_takes_the_place_of_one_that_died_is_found(graph, is_silent_first):
    probe = graph.probe("/x")
    first = graph.add("/x", 1)
    assert probe.process() == 1
    if is_silent_first:
        first.close()
        for _ in range(2):
            with raises_fault(faults.NODE_GONE, "/x", error=NodeGoneError):
                probe.process()
    second = graph.add("/x", 2)
    if not is_silent_first:
        first.close()
    assert probe.process() == 2
    second.close()


def test_a_node_that_hangs_is_silent_after_the_limit(graph):
    with socket.create_server(("127.0.0.1", 0)) as hanging:
        graph.uris["/x"] = f"http://127.0.0.1:{hanging.getsockname()[1]}/"
        with raises_fault(faults.NODE_SILENT, "timed out", error=NodeSilentError) as late:
            graph.probe("/x").process()
    assert not isinstance(late.value, NodeGoneError)


# The query of a probe, against answers of every kind.


def answer(body):
    return f"HTTP/1.1 200 OK\r\nContent-length: {len(body)}\r\n\r\n{body}".encode()


def pid_body(pid, code=1, kind="int"):
    values = f"<value><{kind}>{code}</{kind}></value><value><string></string></value>"
    return f"<data>{values}<value><{kind}>{pid}</{kind}></value></data>"


class QueriedNode:
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
    node = QueriedNode([[answer(pid_body(one, kind=kind))] for one in (4711, 4712, 4713)])
    query = PidQuery(node.uri, "/main<control", PATIENT_S)
    assert [query.ask() for _ in range(3)] == [4711, 4712, 4713]
    assert b"<string>/main&lt;control</string>" in node.requests[0]
    assert node.requests[0].startswith(b"POST / HTTP/1.1\r\n")
    query.close()


def test_a_connection_that_the_node_has_ended_is_made_again():
    in_pieces = [bytes([one]) for one in answer(pid_body(1))]
    node = QueriedNode([in_pieces], [[answer(pid_body(2))]])
    query = PidQuery(node.uri, "/x", PATIENT_S)
    assert [query.ask(), query.ask()] == [1, 2]
    query.close()


@each_case(
    "wrong",
    [
        answer(pid_body(5, code=-1)),
        answer("<fault><int>1</int></fault>"),
        answer("<int>1</int><int>99999999999999</int>"),
        b"HTTP/1.1 200 OK\r\nContent-Length: many\r\n\r\n",
        b"HTTP/1.1 200",
        answer("y" * 200_000),
    ],
)
def test_another_answer_is_an_error(wrong):
    query = PidQuery(QueriedNode([[wrong]]).uri, "/x", PATIENT_S)
    with pytest.raises((ValueError, OSError)):
        query.ask()


@each_case("uri", ["", "http://", "http://127.0.0.1/", "nothing"])
def test_an_address_without_host_or_port_is_refused(uri):
    with pytest.raises(ValueError, match="no host or no port"):
        PidQuery(uri, "/x", PATIENT_S)
