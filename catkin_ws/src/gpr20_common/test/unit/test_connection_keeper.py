"""Subscriptions that lost their connection are made again, once their publisher answers."""

import socket
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from test_node_probe import Server

from gpr20_common.high import connection_keeper
from gpr20_common.high.connection_keeper import BROKEN_LIMIT_S, ConnectionKeeper


class Graph:
    """A master, a publisher, and this node with one subscription."""

    def __init__(self, monkeypatch):
        self.registrations, self.announced = [], []
        self.publisher = Server(getPid=lambda _caller: (1, "", 17))
        self.publishers = [self.publisher.uri]
        self.master = Server(registerSubscriber=self._register)
        self.own = Server(publisherUpdate=self._announce)
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.connection = socket.create_connection(listener.getsockname())
            self.other_end, _address = listener.accept()
        self.subscriber = SimpleNamespace(resolved_name="/topic", connections=[])
        self.published = SimpleNamespace(resolved_name="/own", connections=[])
        topics = SimpleNamespace(
            subs={"/topic": self.subscriber},
            pubs={"/own": self.published},
            get_subscriptions=lambda: [["/topic", "std_msgs/String"]],
        )
        monkeypatch.setattr(connection_keeper, "get_topic_manager", lambda: topics)
        monkeypatch.setattr(connection_keeper.rosgraph, "get_master_uri", lambda: self.master.uri)
        monkeypatch.setattr(connection_keeper.rospy, "get_node_uri", lambda: self.own.uri)
        monkeypatch.setattr(connection_keeper.rospy, "get_name", lambda: "/me")
        monkeypatch.setattr(connection_keeper, "Periodic", lambda _period, _action: None)
        self.keeper = ConnectionKeeper()

    def _register(self, _caller, topic, _type, _uri):
        self.registrations.append(topic)
        return 1, "", self.publishers

    def _announce(self, _caller, topic, publishers):
        self.announced.append((topic, publishers))
        return 1, "", 0

    def connect(self):
        one = SimpleNamespace(endpoint_id=self.publisher.uri, socket=self.connection)
        self.subscriber.connections = [one]

    def close(self):
        for server in (self.publisher, self.master, self.own):
            server.close()
        for one in (self.connection, self.other_end):
            one.close()


@pytest.fixture
def graph(monkeypatch):
    graph = Graph(monkeypatch)
    yield graph
    graph.close()


def test_a_connection_that_breaks_is_made_again(graph):
    graph.keeper.check()
    graph.connect()
    graph.keeper.check()
    assert graph.registrations == []
    graph.subscriber.connections = []
    graph.keeper.check()
    assert graph.announced == [("/topic", [graph.publisher.uri])]
    graph.connect()
    graph.keeper.check()
    graph.keeper.check()
    assert len(graph.announced) == 1
    assert len(graph.registrations) == 2


def test_a_publisher_that_does_not_answer_is_tried_until_it_does(graph):
    graph.connect()
    graph.keeper.check()
    # One that has just ended is no error.
    graph.connection.close()
    graph.keeper.check()
    graph.subscriber.connections = []
    graph.publishers = ["http://127.0.0.1:9/"]
    graph.keeper.check()
    graph.keeper.check()
    assert graph.announced == []
    assert len(graph.registrations) == 2
    graph.publishers = [graph.publisher.uri]
    graph.keeper.check()
    assert graph.announced == [("/topic", [graph.publisher.uri])]


def test_connections_end_when_the_other_end_is_silent_for_too_long(graph):
    graph.connect()
    graph.published.connections = [SimpleNamespace(endpoint_id="/other", socket=graph.other_end)]
    graph.keeper.check()
    for one in (graph.connection, graph.other_end):
        limit_ms = one.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT)
        assert limit_ms == 1000 * BROKEN_LIMIT_S
        assert one.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        assert one.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
