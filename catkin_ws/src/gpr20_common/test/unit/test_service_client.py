"""Service calls over real sockets: answered, too late, given up, and over connections kept open."""

import random
import socket
import struct
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from run_seed import draws
from vanishing_peer import come_back, vanish
from wait_kit import wait_until

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message

pytest.importorskip("rospy")
pytest.importorskip("gpr20_msgs.srv")

import rospy
from rosgraph.network import encode_ros_handshake_header

from gpr20_common.high import service_client
from gpr20_common.high.answers import advertise, message_from
from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_msgs.srv import (
    AddFact,
    AddFactRequest,
    AddFactResponse,
    Command,
    CommandRequest,
)

LIMIT_S = 100.0
SHORT_S = 0.3
DRAWS = draws(2)


class Node:
    """A node that answers each request with its name and the request's survey.

    It may misbehave, as `fault` draws: close the connection before or within an answer, or answer
    when the client has given up. Without `greeting` it does not even accept a call.
    """

    def __init__(self, name="node", fault=lambda: ""):
        self.name = name
        self.fault = fault
        self.listener = socket.create_server(("127.0.0.1", 0), backlog=64)
        self.uri = f"rosrpc://127.0.0.1:{self.listener.getsockname()[1]}"
        self.answering = threading.Event()
        self.answering.set()
        self.greeting = threading.Event()
        self.greeting.set()
        self.ended = threading.Event()
        self.connections = []
        self.requests = []
        threading.Thread(target=self._accept, daemon=True).start()

    def end(self):
        """End as a process does: the system closes everything."""
        # Closing alone leaves the thread in `accept`, where it takes one more connection.
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        for one in self.connections:
            one.shutdown(socket.SHUT_RDWR)

    def _accept(self):
        while True:
            try:
                connection, _address = self.listener.accept()
            except OSError:
                return
            self.connections.append(connection)
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with connection, connection.makefile("rb") as stream:
            try:
                header = stream.read(*struct.unpack("<I", stream.read(4)))
                if self.greeting.wait(LIMIT_S):
                    fields = {"md5sum": AddFact._md5sum, "type": AddFact._type}
                    connection.sendall(encode_ros_handshake_header(fields))
                while self._answer(connection, stream) and b"persistent=1" in header:
                    pass
            except (OSError, struct.error, ValueError):
                return
            finally:
                self.ended.set()

    def _answer(self, connection, stream):
        data = stream.read(*struct.unpack("<I", stream.read(4)))
        request = deserialized(AddFactRequest, data)
        self.requests.append(request.survey)
        text = f"{self.name} {request.survey}"
        answer = serialized(AddFactResponse(success=True, message=text))
        answer = struct.pack("<?I", True, len(answer)) + answer
        fault = self.fault()
        self.answering.wait(LIMIT_S)
        if fault == "late":
            time.sleep(1.5 * SHORT_S)
        elif fault in ("close", "cut"):
            connection.sendall(answer[:-3] if fault == "cut" else b"")
            return False
        for one in [answer[:7], answer[7:]] if fault == "pieces" else [answer]:
            connection.sendall(one)
        return True


class Graph:
    """Which node offers the service now, as the master knows it."""

    def __init__(self, monkeypatch):
        self.node = Node()
        self.lookups = 0
        monkeypatch.setattr(ServiceClient, "_look_up", lambda *_arguments: self._look_up())

    def _look_up(self):
        self.lookups += 1
        return self.node.uri

    def replace(self, name="other"):
        former, self.node = self.node, Node(name)
        return former


@pytest.fixture
def graph(monkeypatch):
    return Graph(monkeypatch)


def call(client, survey, limit_s=LIMIT_S):
    return client.call(limit_s, survey=survey).message


def test_a_call_that_is_given_up_before_it_is_connected_is_never_made(graph):
    graph.node.greeting.clear()
    with raises_fault(faults.PART_SILENT, "homing", 0.3, error=ServiceUnavailableError):
        call(ServiceClient("homing", AddFact), "a", SHORT_S)
    graph.node.greeting.set()
    assert graph.node.ended.wait(LIMIT_S)
    assert graph.node.connections and graph.node.requests == []


@pytest.mark.needs("socket filters")
def test_a_request_that_was_given_up_in_a_broken_link_is_not_delivered_when_it_is_back(graph):
    client = ServiceClient("add_fact", AddFact, keep_open=True)
    assert call(client, "a") == "node a"
    (end,) = graph.node.connections
    vanish(end)
    with raises_fault(faults.PART_SILENT):
        call(client, "b", SHORT_S)
    come_back(end)
    assert call(client, "c") == "node c"
    # So long TCP would take to send it once more.
    assert not threading.Event().wait(4.0 * SHORT_S)
    assert graph.node.requests == ["a", "c"]


def test_calls_that_follow_each_other_use_one_connection_and_one_lookup(graph):
    client = ServiceClient("add_fact", AddFact, keep_open=True)
    assert [call(client, one) for one in "abc"] == ["node a", "node b", "node c"]
    assert (len(graph.node.connections), graph.lookups) == (1, 1)


@pytest.mark.parametrize("lives", [True, False])
def test_a_node_that_was_started_again_or_replaced_is_found(graph, monkeypatch, lives):
    client = ServiceClient("add_fact", AddFact, keep_open=True)
    call(client, "a")
    former = graph.replace()
    before = list(former.requests)
    if lives:
        # As if the time had passed within which no node can take the name of another.
        monkeypatch.setattr(service_client, "REUSE_S", 0.0)
    else:
        former.end()
    assert call(client, "b") == "other b"
    assert former.requests == before


def test_calls_in_parallel_do_not_wait_for_each_other(graph):
    client = ServiceClient("add_fact", AddFact, keep_open=True)
    graph.node.answering.clear()
    with ThreadPoolExecutor(2) as pool:
        waiting = pool.submit(call, client, "a", LIMIT_S)
        wait_until(lambda: graph.node.requests)
        former = graph.replace()
        assert call(client, "b") == "other b"
        former.end()
        with pytest.raises(ServiceUnavailableError):
            waiting.result(LIMIT_S)


@each_case("seed", range(DRAWS))
def test_every_answer_is_that_to_its_own_request_whatever_the_node_does(monkeypatch, seed):
    graph = Graph(monkeypatch)
    chance = random.Random(seed)
    kinds = ["", "", "", "pieces", "close", "cut", "late"]
    client = ServiceClient("add_fact", AddFact, keep_open=True)
    graph.node.fault = lambda: chance.choice(kinds)

    def calls(name):
        answered = 0
        for number in range(6):
            try:
                answer = call(client, f"{name}.{number}", SHORT_S)
            except ServiceUnavailableError:
                continue
            assert answer == f"node {name}.{number}"
            answered += 1
        return answered

    with ThreadPoolExecutor(4) as pool:
        assert sum(pool.map(calls, "abcd")) > 0
    # No request was made twice.
    assert len(set(graph.node.requests)) == len(graph.node.requests)


# What a service answers.


@pytest.fixture
def ask(monkeypatch):
    """Return what asks a service whose handler is given."""
    monkeypatch.setattr(rospy, "Service", lambda _name, _class, handler: handler)
    return lambda handler: advertise("homing", Command, handler)(CommandRequest())


REFUSED = Message("{axis} is refused", axis="x")


@each_case(
    "error, fault",
    [
        (InvalidValueError(REFUSED), faults.NOT_ALLOWED),
        (InvalidValueError(REFUSED, fault=faults.DISK_FULL), faults.DISK_FULL),
        (KeyError("x"), faults.INTERNAL),
    ],
)
def test_an_error_becomes_an_answer_with_its_fault(ask, error, fault):
    def handler(_request):
        raise error

    answer = ask(handler)
    assert not answer.success and str(error) in answer.message
    assert answer.fault.code == fault.code and message_from(answer).cause == fault


def test_equal_refusals_in_a_row_are_one_line(monkeypatch):
    lines, refusals = [], [*["a"] * 5, None, "a", "b"]
    monkeypatch.setattr(rospy, "logwarn", lambda form, *values: lines.append(form % values))
    monkeypatch.setattr(rospy, "Service", lambda _name, _class, handler: handler)

    def handle(_request):
        refusal = refusals.pop(0)
        if refusal is not None:
            raise InvalidValueError(Message("{value}", value=refusal))

    answer = advertise("stop", Command, handle)
    for _request in range(8):
        answer(CommandRequest())
    assert lines == [
        "stop refused: a",
        "stop refused: a",
        "stop refused: b",
    ]
