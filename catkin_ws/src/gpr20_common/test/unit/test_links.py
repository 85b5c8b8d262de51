"""Links over real sockets: nodes that live, died, hang or restarted, and ends that vanish."""

import socket
import threading
from xmlrpc.server import SimpleXMLRPCRequestHandler

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from robot_kit import RpcServer

from gpr20_common import faults
from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.low.links import NodeProbe

# For what comes, and for what never comes.
LIMIT_S, SHORT_S = 100.0, 2.0


class Graph:
    """A master that knows nodes."""

    def __init__(self):
        self.uris = {}
        self.master = RpcServer(lookupNode=self._look_up)
        self.lookups = 0

    def _look_up(self, _caller, name):
        self.lookups += 1
        uri = self.uris.get(name)
        return (1, "", uri) if uri else (-1, f"unknown node [{name}]", "")

    def add(self, answer):
        node = RpcServer(getPid=lambda _caller: answer)
        self.uris["/x"] = node.uri
        return node

    def probe(self, limit_s=LIMIT_S):
        return NodeProbe(self.master.uri, "/asker", "/x", limit_s)


@pytest.fixture
def graph():
    graph = Graph()
    yield graph
    graph.master.close()


def test_a_node_that_lives_tells_its_process_and_is_not_silent_because_the_master_dies(graph):
    node = graph.add((1, "", 4711))
    probe = graph.probe()
    assert [probe.process() for _ in range(3)] == [4711, 4711, 4711]
    assert graph.lookups == 1
    graph.uris.clear()
    assert probe.process() == 4711
    node.close()


@pytest.mark.parametrize("is_silent_first", [True, False])
def test_a_node_that_takes_the_place_of_one_that_died_is_found(graph, is_silent_first):
    probe = graph.probe()
    with raises_fault(faults.PART_SILENT, "/x", "unknown node", error=NodeGoneError):
        probe.process()
    first = graph.add((1, "", 1))
    assert probe.process() == 1
    if is_silent_first:
        first.close()
        for _ in range(2):
            with raises_fault(faults.PART_SILENT, "/x", error=NodeGoneError):
                probe.process()
    second = graph.add((1, "", 2))
    if not is_silent_first:
        first.close()
    assert probe.process() == 2
    second.close()


class KeptConnections(SimpleXMLRPCRequestHandler):
    protocol_version = "HTTP/1.1"


def test_one_connection_serves_many_queries_and_is_made_again_when_the_node_has_ended_it(graph):
    node = graph.add((1, "", 4711))
    # Of a node that ends it after each answer one is made for each.
    ended = len(set(connections_of(node, graph.probe())))
    node.server.RequestHandlerClass = KeptConnections
    assert (ended, len(set(connections_of(node, graph.probe())))) == (3, 1)
    node.close()


def connections_of(node, probe):
    accepted, accept = [], node.server.process_request

    def noted(request, address):
        accepted.append(address)
        accept(request, address)

    node.server.process_request = noted
    assert [probe.process() for _ in range(3)] == [4711] * 3
    return accepted


@each_case("answer", [(-1, "no", 5), (1, "", "many"), (1, ""), 7])
def test_another_answer_is_no_answer(graph, answer):
    node = graph.add(answer)
    with raises_fault(faults.PART_SILENT, "/x", error=NodeSilentError):
        graph.probe().process()
    node.close()


@each_case("answer", [b"", b"no HTTP\r\n\r\n"])
def test_a_node_that_hangs_or_answers_in_no_language_of_ours_is_silent(graph, answer):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        graph.uris["/x"] = f"http://127.0.0.1:{listener.getsockname()[1]}/"
        accepted = []

        def accept():
            accepted.append(listener.accept()[0])
            accepted[0].sendall(answer)

        answering = threading.Thread(target=accept)
        answering.start()
        with raises_fault(faults.PART_SILENT, "/x", error=NodeSilentError) as silent:
            graph.probe(SHORT_S).process()
        answering.join()
        accepted[0].close()
    assert not isinstance(silent.value, NodeGoneError)
    assert ("timed out" in str(silent.value)) == (not answer)
