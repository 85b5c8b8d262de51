"""Connections of topics that heal by themselves after a link was down."""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Set

import rosgraph
import rospy
from rospy.impl.registration import get_topic_manager

from gpr20_common.high.periodic import Periodic
from gpr20_common.low.limited_rpc import NO_ANSWER, limited_server, value_of
from gpr20_common.low.tcp_keepalive import end_when_broken, send_at_once

PERIOD_S = 1.0
# A connection whose other end has not answered for this time is ended [s].
BROKEN_LIMIT_S = 10.0
ANSWER_LIMIT_S = 3.0


class ConnectionKeeper:
    """Ends the broken topic connections of this node, and makes lost subscriptions again.

    rospy leaves a broken connection open for minutes, and never connects a subscription again
    that has lost its connection: it expects that the master announces the publisher once more,
    which it does only for publishers that were restarted.
    """

    def __init__(self) -> None:
        self._connected: Dict[str, Set[str]] = {}
        self._lost: Set[str] = set()
        self._periodic = Periodic(PERIOD_S, self.check)

    def close(self) -> None:
        """Stop looking after the connections."""
        self._periodic.stop()

    def check(self) -> None:
        """Set the limits of new connections; connect subscriptions that were lost."""
        topics = get_topic_manager()
        for publisher in _copy(topics.pubs):
            for connection in _sockets(publisher):
                _protect(connection)
        connected = {}
        for subscriber in _copy(topics.subs):
            for connection in _sockets(subscriber):
                _protect(connection)
            connected[subscriber.resolved_name] = {
                one.endpoint_id for one in subscriber.connections if one.socket is not None
            }
        self._lost |= {
            name
            for name, publishers in connected.items()
            if self._connected.get(name, set()) - publishers
        }
        self._connected = connected
        self._lost &= connected.keys()
        if self._lost:
            self._connect()

    def _connect(self) -> None:
        master = limited_server(rosgraph.get_master_uri(), ANSWER_LIMIT_S)
        types = dict(get_topic_manager().get_subscriptions())
        answering: Dict[str, bool] = {}
        for name in sorted(self._lost & types.keys()):
            try:
                publishers = value_of(
                    master.registerSubscriber(
                        rospy.get_name(), name, types[name], rospy.get_node_uri()
                    )
                )
            except NO_ANSWER as error:
                rospy.logdebug("the master does not answer: %s", error)
                return
            missing = [uri for uri in publishers if uri not in self._connected[name]]
            if not missing:
                self._lost.discard(name)
            for uri in missing:
                if uri not in answering:
                    answering[uri] = _answers(uri)
            self._announce(name, [uri for uri in missing if answering[uri]])

    def _announce(self, name: str, publishers: List[str]) -> None:
        """Do what the master does when publishers are new: rospy connects to them."""
        if publishers:
            rospy.loginfo("connecting to %s again", name)
            own = limited_server(rospy.get_node_uri(), ANSWER_LIMIT_S)
            try:
                value_of(own.publisherUpdate(rospy.get_name(), name, publishers))
            except NO_ANSWER as error:
                rospy.logwarn("could not connect to %s again: %s", name, error)


def _copy(topics: Dict[str, Any]) -> List[Any]:
    # Other threads add topics.
    return list(topics.values())


def _sockets(topic: Any) -> Iterator[Any]:
    for one in topic.connections:
        # One that waits to be made has no socket.
        connection = one.socket
        if connection is not None:
            yield connection


def _protect(connection: Any) -> None:
    try:
        end_when_broken(connection, BROKEN_LIMIT_S)
        send_at_once(connection)
    except OSError as error:
        # It was closed after it was listed.
        rospy.logdebug("a connection has ended: %s", error)


def _answers(uri: str) -> bool:
    try:
        value_of(limited_server(uri, ANSWER_LIMIT_S).getPid(rospy.get_name()))
        return True
    except NO_ANSWER:
        return False
