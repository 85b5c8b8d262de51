"""A node stays known to its master, connected, and free of strangers."""

import contextlib
import socket
import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from robot_kit import RpcServer
from rosgraph.network import encode_ros_handshake_header
from rosgraph.xmlrpc import SilenceableXMLRPCRequestHandler as Handler
from rosgraph.xmlrpc import ThreadingXMLRPCServer, XmlRpcHandler, XmlRpcNode
from rospy.impl.tcpros_base import TCPServer

from gpr20_common.high import graph_keeper
from gpr20_common.high.graph_keeper import (
    BROKEN_LIMIT_S,
    MOST_OPEN,
    GraphKeeper,
    _Doorman,
)

LIMIT_S = 100.0
HEADER = encode_ros_handshake_header({"service": "/stop", "callerid": "/me"})
PARAMETERS = {"run_id": "1", "launch": "{}", "gpr20_started": {"launch": {"me": True}}}


class Graph:
    """A master that remembers what it was told, a publisher, and this node with what it tells."""

    def __init__(self):
        self.process, self.known, self.parameters, self.told = 7, 1, PARAMETERS, []
        self.node = RpcServer(publisherUpdate=lambda _caller, *new: self._tell(*new))
        self.publisher = RpcServer(getPid=lambda _caller: (1, "", 17))
        self.publishers = [self.publisher.uri]
        self.master = RpcServer(
            getPid=lambda _caller: (1, "", self.process),
            lookupNode=lambda _caller, _node: (self.known, "", "http://me"),
            getParam=lambda _caller, _name: (1, "", self.parameters),
            setParam=lambda _caller, name, value: self._tell(name, value),
            registerSubscriber=lambda _caller, name, *_rest: self._tell(name),
            registerService=lambda _caller, name, *_rest: self._tell(name),
            registerPublisher=lambda _caller, name, *_rest: self._tell(name),
        )
        for one in (self.master, self.node):
            one.server.register_multicall_functions()
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.connection = socket.create_connection(listener.getsockname())
            self.other_end, _address = listener.accept()
        self.subs = {"/heard": SimpleNamespace(connections=[])}
        self.pubs = {"/said": SimpleNamespace(connections=[])}

    def connect(self):
        one = SimpleNamespace(endpoint_id=self.publisher.uri, socket=self.connection)
        self.subs["/heard"].connections = [one]

    def lose(self):
        self.subs["/heard"].connections = []

    def get_subscriptions(self):
        return [["/heard", "a/Type"]]

    def get_publications(self):
        return [["/said", "a/Type"]]

    def get_services(self):
        return [["/asked", "rosrpc://here"]]

    def close(self):
        for server in (self.publisher, self.master, self.node):
            server.close()
        for one in (self.connection, self.other_end):
            one.close()

    def _tell(self, *what):
        self.told.append(what)
        return 1, "", self.publishers


@pytest.fixture
def graph(monkeypatch):
    graph = Graph()
    for name in ("get_topic_manager", "get_service_manager"):
        monkeypatch.setattr(graph_keeper, name, lambda: graph)
    monkeypatch.setattr(graph_keeper.rosgraph, "get_master_uri", lambda: graph.master.uri)
    monkeypatch.setattr(graph_keeper.rospy, "get_node_uri", lambda: graph.node.uri)
    monkeypatch.setattr(graph_keeper.rospy, "get_name", lambda: "/me")
    nothing = SimpleNamespace(tcp_ros_server=None)
    for name in ("start_tcpros_server", "init_tcpros_server"):
        monkeypatch.setattr(graph_keeper.tcpros_base, name, lambda: nothing)
    for name in ("_Doorman", "_limit_requests", "Periodic"):
        monkeypatch.setattr(graph_keeper, name, lambda *_given: None)
    yield graph
    graph.close()


def announced(graph):
    return ("/heard", [graph.publisher.uri])


def test_a_master_that_comes_back_empty_is_filled_and_only_then(graph, monkeypatch):
    keeper = GraphKeeper()
    keeper.check()
    keeper.check()
    assert graph.told == []
    graph.parameters = {"launch": "of another value"}
    filled = [("/asked",), ("/said",), ("/run_id", "1"), ("/gpr20_started/launch/me", True)]
    for change in ({"process": 8}, {"known": -1}, {"known": 1, "process": 9}):
        graph.__dict__.update(change, told=[])
        keeper.check()
        assert graph.told == [*filled, ("/heard",), announced(graph)], change
    graph.connect()
    keeper.check()
    keeper.check()
    assert graph.told[len(filled) + 2 :] == [("/heard",)]
    # A node that ends has taken its name away itself.
    monkeypatch.setattr(graph_keeper.rospy.core, "is_shutdown_requested", lambda: True)
    graph.__dict__.update(known=-1, told=[])
    keeper.check()
    assert graph.told == []


def test_a_connection_that_breaks_is_made_again_once_its_publisher_answers(graph):
    keeper = GraphKeeper()
    keeper.check()
    graph.connect()
    keeper.check()
    # One that has just ended is no error.
    graph.connection.close()
    keeper.check()
    assert graph.told == []
    graph.lose()
    graph.publishers = ["http://127.0.0.1:9/"]
    keeper.check()
    keeper.check()
    assert graph.told == 2 * [("/heard",)]
    graph.publishers = [graph.publisher.uri]
    keeper.check()
    assert graph.told[2:] == [("/heard",), announced(graph)]
    graph.connect()
    keeper.check()
    keeper.check()
    assert graph.told[4:] == [("/heard",)]


def test_connections_end_when_the_other_end_is_silent_for_too_long(graph):
    graph.connect()
    said = SimpleNamespace(endpoint_id="/other", socket=graph.other_end)
    graph.pubs["/said"].connections = [said]
    GraphKeeper().check()
    for one in (graph.connection, graph.other_end):
        limit_ms = one.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT)
        assert limit_ms == 1000 * BROKEN_LIMIT_S
        assert one.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        assert one.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


@pytest.fixture
def port(monkeypatch):
    """The address of a node that tells who has said a whole header, and its doorman."""
    # A busy computer must not make what is said in pieces too late.
    monkeypatch.setattr(graph_keeper, "HEADER_LIMIT_S", 5.0)
    said, more = [], threading.Condition()

    def begin(connection, _address):
        with more:
            said.append(connection.recv(len(HEADER)))
            more.notify_all()
        connection.close()

    server = TCPServer(begin)
    doorman = _Doorman(server)
    doorman.noted = []
    doorman.note = doorman.noted.append
    server.start()

    def heard(count):
        with more:
            return more.wait_for(lambda: len(said) == count, LIMIT_S) and said

    yield ("127.0.0.1", server.port), doorman.noted, heard
    server.shutdown()


def is_ended(connection):
    connection.settimeout(LIMIT_S)
    try:
        return connection.recv(1) == b""
    except ConnectionResetError:
        return True


def test_a_header_is_heard_in_pieces_and_does_not_wait_for_strangers(port, monkeypatch):
    address, noted, heard = port
    # Of a slow friend on a busy computer.
    monkeypatch.setattr(graph_keeper, "HEADER_LIMIT_S", 5.0)
    openings = [b"", HEADER[:2], HEADER[:20], b"\xff\xff\xff\x7f", b"\0\0\0\0"]
    strangers = [socket.create_connection(address) for _ in range(2 * MOST_OPEN)]
    for place, stranger in enumerate(strangers):
        with contextlib.suppress(ConnectionError):  # one that was too many
            stranger.sendall(openings[place % len(openings)])
    with socket.create_connection(address) as slow, socket.create_connection(address) as fast:
        slow.sendall(HEADER[:9])
        fast.sendall(HEADER)
        assert heard(1) == [HEADER]
        slow.sendall(HEADER[9:])
        assert heard(2) == [HEADER, HEADER]
    assert all(map(is_ended, strangers))
    assert set(noted) == {one.getsockname() for one in strangers}
    for stranger in strangers:
        stranger.close()


def test_who_closes_a_connection_is_no_stranger(port):
    address, noted, heard = port
    for _ in range(MOST_OPEN):
        socket.create_connection(address).close()
    with socket.create_connection(address) as node:
        node.sendall(HEADER)
        assert heard(1) == [HEADER]
    assert noted == []


def test_the_xml_rpc_of_a_node_has_a_bounded_number_of_connections(monkeypatch):
    for owner, name in ((ThreadingXMLRPCServer, "process_request"), (Handler, "timeout")):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    noted = []
    graph_keeper._limit_requests(SimpleNamespace(note=noted.append))
    node = XmlRpcNode(rpc_handler=XmlRpcHandler())
    node._run_init()
    threading.Thread(target=node.server.serve_forever, args=(0.01,), daemon=True).start()
    strangers = [socket.create_connection(node.server.server_address) for _ in range(MOST_OPEN + 9)]
    for stranger in strangers:
        with contextlib.suppress(ConnectionError):  # one that was too many
            stranger.sendall(b"POST /RPC2 HTTP/1.1\r\n")
    assert all(map(is_ended, strangers))
    assert {one.getsockname() for one in strangers[:9]} >= set(noted) != set()
    node.server.shutdown()
    node.server.server_close()
    for stranger in strangers:
        stranger.close()
