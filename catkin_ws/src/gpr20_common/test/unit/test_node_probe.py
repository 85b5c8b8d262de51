"""Asking nodes over real sockets: alive, dead, hanging, unknown, restarted."""

import socket
import threading
import time
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from fault_kit import raises_fault

from gpr20_common import faults
from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.low.node_probe import NodeProbe

LIMIT_S = 0.5


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


def test_a_node_that_lives_tells_its_process(graph):
    node = graph.add("/x", 4711)
    probe = graph.probe("/x")
    assert [probe.process() for _ in range(3)] == [4711, 4711, 4711]
    assert graph.lookups == 1
    node.close()


def test_a_node_that_the_master_does_not_know_is_silent(graph):
    with raises_fault(faults.NODE_GONE, "/x", "unknown node", error=NodeGoneError):
        graph.probe("/x").process()


def test_a_node_that_dies_is_silent_and_one_that_takes_its_place_is_found(graph):
    probe = graph.probe("/x")
    first = graph.add("/x", 1)
    assert probe.process() == 1
    first.close()
    for _ in range(2):
        with raises_fault(faults.NODE_GONE, "/x", error=NodeGoneError):
            probe.process()
    second = graph.add("/x", 2)
    assert probe.process() == 2
    second.close()


def test_a_node_that_was_restarted_is_not_silent_for_one_that_knows_its_old_address(graph):
    probe = graph.probe("/x")
    first = graph.add("/x", 1)
    assert probe.process() == 1
    second = graph.add("/x", 2)
    first.close()
    assert probe.process() == 2
    second.close()


def test_a_node_does_not_become_silent_because_the_master_dies(graph):
    node = graph.add("/x", 1)
    probe = graph.probe("/x")
    probe.process()
    graph.uris.clear()
    assert probe.process() == 1
    node.close()


def test_a_node_that_hangs_is_silent_after_the_limit(graph):
    with socket.socket() as hanging:
        hanging.bind(("127.0.0.1", 0))
        hanging.listen()
        graph.uris["/x"] = f"http://127.0.0.1:{hanging.getsockname()[1]}/"
        begun_s = time.monotonic()
        with raises_fault(faults.NODE_SILENT, "timed out", error=NodeSilentError) as late:
            graph.probe("/x").process()
        assert not isinstance(late.value, NodeGoneError)
        assert LIMIT_S <= time.monotonic() - begun_s < 10 * LIMIT_S


def test_a_master_that_refuses_connections_does_not_make_a_node_one_that_has_ended(graph):
    probe = graph.probe("/x")
    graph.master.close()
    with pytest.raises(NodeSilentError) as silent:
        probe.process()
    assert not isinstance(silent.value, NodeGoneError)


def test_an_answer_that_is_none_is_silence(graph):
    node = Server(getPid=lambda _caller: "nonsense")
    graph.uris["/x"] = node.uri
    with raises_fault(faults.NODE_SILENT, "/x", error=NodeSilentError):
        graph.probe("/x").process()
    node.close()
