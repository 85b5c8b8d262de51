"""A node fills a master that comes back empty, and its ports do not wait for strangers."""

import contextlib
import socket
import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from rosgraph.network import encode_ros_handshake_header
from rosgraph.xmlrpc import SilenceableXMLRPCRequestHandler as Handler
from rosgraph.xmlrpc import ThreadingXMLRPCServer, XmlRpcHandler, XmlRpcNode
from rospy.impl.tcpros_base import TCPServer
from test_node_probe import Server

from gpr20_common.high import graph_keeper
from gpr20_common.high.graph_keeper import MOST_OPEN, GraphKeeper, _Doorman

LIMIT_S = 20.0
HEADER = encode_ros_handshake_header({"service": "/stop", "callerid": "/me"})
PARAMETERS = {"run_id": "1", "launch": "{}", "gpr20_started": {"launch": {"me": True}}}


class Master:
    """A master that remembers what it was told, and this node with what it tells."""

    def __init__(self):
        self.process, self.known, self.parameters, self.told = 7, 1, PARAMETERS, []
        self.server = Server(
            getPid=lambda _caller: (1, "", self.process),
            lookupNode=lambda _caller, _node: (self.known, "", "http://me"),
            getParam=lambda _caller, _name: (1, "", self.parameters),
            setParam=lambda _caller, name, value: self._tell(name, value),
            registerSubscriber=lambda _caller, name, *_rest: self._tell(name),
            registerService=lambda _caller, name, *_rest: self._tell(name),
            registerPublisher=lambda _caller, name, *_rest: self._tell(name),
        )
        self.node = Server(publisherUpdate=lambda _caller, *new: self._tell(*new))
        for one in (self.server, self.node):
            one.server.register_multicall_functions()

    def _tell(self, *what):
        self.told.append(what)
        return 1, "", ["http://publisher"]


@pytest.fixture
def master(monkeypatch):
    master = Master()
    graph = SimpleNamespace(
        get_subscriptions=lambda: [["/heard", "a/Type"]],
        get_publications=lambda: [["/said", "a/Type"]],
        get_services=lambda: [["/asked", "rosrpc://here"]],
    )
    for name in ("get_topic_manager", "get_service_manager"):
        monkeypatch.setattr(graph_keeper, name, lambda: graph)
    monkeypatch.setattr(graph_keeper.rosgraph, "get_master_uri", lambda: master.server.uri)
    monkeypatch.setattr(graph_keeper.rospy, "get_node_uri", lambda: master.node.uri)
    monkeypatch.setattr(graph_keeper.rospy, "get_name", lambda: "/me")
    nothing = SimpleNamespace(tcp_ros_server=None)
    for name in ("start_tcpros_server", "init_tcpros_server"):
        monkeypatch.setattr(graph_keeper.tcpros_base, name, lambda: nothing)
    for name in ("_Doorman", "_limit_requests", "ConnectionKeeper", "Periodic"):
        monkeypatch.setattr(graph_keeper, name, lambda *_given: None)
    yield master
    master.server.close()
    master.node.close()


def test_a_master_that_comes_back_empty_is_filled_and_only_then(master, monkeypatch):
    keeper = GraphKeeper()
    keeper.check()
    keeper.check()
    assert master.told == []
    master.parameters = {"launch": "of another value"}
    registered = [("/heard",), ("/asked",), ("/said",)]
    filled = [*registered, ("/run_id", "1"), ("/gpr20_started/launch/me", True)]
    connected = ("/heard", ["http://publisher"])
    for change in ({"process": 8}, {"known": -1}, {"known": 1, "process": 9}):
        master.__dict__.update(change, told=[])
        keeper.check()
        assert master.told == [*filled, connected], change
    keeper.check()
    assert len(master.told) == len(filled) + 1
    # A node that ends has taken its name away itself.
    monkeypatch.setattr(graph_keeper.rospy.core, "is_shutdown_requested", lambda: True)
    master.__dict__.update(known=-1, told=[])
    keeper.check()
    assert master.told == []


@pytest.fixture
def port():
    """The address of a node that tells who has said a whole header, and its doorman."""
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


def test_a_header_is_heard_in_pieces_and_does_not_wait_for_strangers(port):
    address, noted, heard = port
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
