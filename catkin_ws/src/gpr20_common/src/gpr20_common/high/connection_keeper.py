"""Connections of topics: who subscribes, and how they heal after a link was down."""

from __future__ import annotations

import contextlib
import functools
import socket
from typing import Any, Dict, Set

import rosgraph
import rospy
from rospy.impl.registration import get_topic_manager

from gpr20_common.high.periodic import Periodic
from gpr20_common.low.links import NO_ANSWER, end_when_broken, limited_server, value_of

PERIOD_S = 1.0
# A connection whose other end has not answered for this time is ended [s].
BROKEN_LIMIT_S = 10.0
ANSWER_LIMIT_S = 3.0


class ConnectionKeeper:
    """Ends the broken topic connections of this node, and makes lost subscriptions again.

    rospy leaves a broken connection open for minutes, and never makes a lost one again: it waits
    for the master to announce the publisher, which it does only for one that was restarted.
    """

    def __init__(self) -> None:
        self._connected: Dict[str, Set[str]] = {}
        self._lost: Set[str] = set()
        self._periodic = Periodic(PERIOD_S, self.check)

    def close(self) -> None:
        self._periodic.stop()

    def check(self) -> None:
        topics = get_topic_manager()
        # Copied, because other threads add topics.
        for publisher in list(topics.pubs.values()):
            _protect(publisher)
        subscribers = list(topics.subs.values())
        connected = {one.resolved_name: _protect(one) for one in subscribers}
        for name, publishers in connected.items():
            if self._connected.get(name, set()) - publishers:
                self._lost.add(name)
        self._connected = connected
        self._lost &= connected.keys()
        if self._lost:
            self._connect(dict(topics.get_subscriptions()))

    def _connect(self, types: Dict[str, str]) -> None:
        me, uri = rospy.get_name(), rospy.get_node_uri()
        master = limited_server(rosgraph.get_master_uri(), ANSWER_LIMIT_S)
        answers = functools.lru_cache(maxsize=None)(functools.partial(_answers, me))
        for name in sorted(self._lost & types.keys()):
            try:
                publishers = value_of(master.registerSubscriber(me, name, types[name], uri))
                missing = [one for one in publishers if one not in self._connected[name]]
                if not missing:
                    self._lost.discard(name)
                # rospy would wait without a limit for one that does not answer.
                found = [one for one in missing if answers(one)]
                if found:
                    rospy.loginfo("connecting to %s again", name)
                    # What the master does when publishers are new: rospy connects to them.
                    value_of(limited_server(uri, ANSWER_LIMIT_S).publisherUpdate(me, name, found))
            except NO_ANSWER as error:
                rospy.logwarn_throttle(10.0, f"{name} is not connected again: {error}")


def subscriber_count(topic: str) -> int:
    """Return how many nodes subscribe to a topic (absolute name); they connect some time later."""
    _published, subscribed, _services = rosgraph.Master(rospy.get_name()).getSystemState()
    return len(dict(subscribed).get(topic, ()))


def _protect(topic: Any) -> Set[str]:
    """Set the limits of a topic's connections; return the other end of each."""
    connected = set()
    for one in topic.connections:
        connection = one.socket
        # One that waits to be made has no socket.
        if connection is not None:
            connected.add(one.endpoint_id)
            try:
                end_when_broken(connection, BROKEN_LIMIT_S)
                # Small messages must not wait for the acknowledgement of earlier ones.
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            except OSError as error:
                # It was closed after it was listed.
                rospy.logdebug("a connection has ended: %s", error)
    return connected


def _answers(caller: str, uri: str) -> bool:
    with contextlib.suppress(*NO_ANSWER):
        value_of(limited_server(uri, ANSWER_LIMIT_S).getPid(caller))
        return True
    return False
