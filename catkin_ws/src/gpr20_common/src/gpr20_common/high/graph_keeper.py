"""Keeping a node in the ROS graph: known to its master, connected, and free of strangers.

rospy registers a node once, so a master that was restarted would never know it again. It leaves a
broken connection of a topic open for minutes, and never makes a lost one again: it waits for the
master to announce the publisher, which it does only for one that was restarted. It reads the
header of each connection in the thread that accepts all of them, and gives each connection to its
XML-RPC a thread without a limit: strangers who say half would keep STOP waiting.
"""

from __future__ import annotations

import contextlib
import functools
import selectors
import socket
import struct
import time
from typing import Any, Dict, Iterator, List, Set, Tuple
from xmlrpc.client import MultiCall

import rosgraph
import rospy
from rosgraph.xmlrpc import SilenceableXMLRPCRequestHandler, ThreadingXMLRPCServer
from rospy.impl import tcpros_base
from rospy.impl.registration import get_service_manager, get_topic_manager

from gpr20_common.high.periodic import Periodic
from gpr20_common.low.links import NO_ANSWER, answers, end_when_broken, limited_server, value_of

# The code of an answer that reports no failure.
SUCCESS = 1
PERIOD_S = 1.0
ANSWER_LIMIT_S = 3.0
# A connection whose other end has not answered for this time is ended [s].
BROKEN_LIMIT_S = 10.0
# One check of so many also remembers the parameters.
REMEMBER_EVERY = 30
# To send the header of a connection, or the next line of a request [s].
HEADER_LIMIT_S = 2.0
# So many connections may wait without a header, and be open to XML-RPC; the oldest is ended.
MOST_OPEN = 100
LARGEST_HEADER_BYTES = 1 << 16
LENGTH = struct.Struct("<I")
POLL_S = 0.5
# Strangers, and a master that does not answer, are logged this often [s].
SAY_PERIOD_S = 10.0


class GraphKeeper:
    """Keeps this node known to its master, its connections whole, and its ports free."""

    def __init__(self) -> None:
        tcpros_base.start_tcpros_server()
        _limit_requests(_Doorman(tcpros_base.init_tcpros_server().tcp_ros_server))
        self._master = limited_server(rosgraph.get_master_uri(), ANSWER_LIMIT_S)
        self._filled = 0
        self._parameters: Dict[str, Any] = {}
        self._checks = 0
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
        connected = {name: _protect(one) for name, one in list(topics.subs.items())}
        for name, publishers in connected.items():
            if self._connected.get(name, set()) - publishers:
                self._lost.add(name)
        self._connected = connected
        self._lost &= connected.keys()
        me, uri = rospy.get_name(), rospy.get_node_uri()
        try:
            self._know_master(me, uri)
            if self._lost:
                self._connect(me, uri)
        except NO_ANSWER as error:
            rospy.logwarn_throttle(SAY_PERIOD_S, f"the ROS graph does not answer: {error}")

    def _know_master(self, me: str, uri: str) -> None:
        """Fill a master that does not know this node, or is not the one that was filled."""
        ask: Any = MultiCall(self._master)
        # A rebooted computer can give the same process id; a name can be known by one topic alone.
        ask.getPid(me)
        ask.lookupNode(me, me)
        process, (known, _message, _uri) = list(ask())
        number = value_of(process)
        if known != SUCCESS or self._filled not in (0, number):
            # A node that ends has taken its name away itself.
            if rospy.core.is_shutdown_requested():
                return
            self._fill(me, uri)
            rospy.logwarn("the ROS master was restarted; this part is known to it again")
        self._filled = number
        if self._checks % REMEMBER_EVERY == 0:
            self._parameters.update(_leaves(value_of(self._master.getParam(me, "/"))))
        self._checks += 1

    def _fill(self, me: str, uri: str) -> None:
        fill: Any = MultiCall(self._master)
        for name, address in get_service_manager().get_services():
            fill.registerService(me, name, address, uri)
        for name, kind in get_topic_manager().get_publications():
            fill.registerPublisher(me, name, kind, uri)
        there = dict(_leaves(value_of(self._master.getParam(me, "/"))))
        # The id of the run first: who finds its configuration needs it, too.
        for name in sorted(self._parameters.keys() - there.keys(), key="/run_id".__ne__):
            fill.setParam(me, name, self._parameters[name])
        list(map(value_of, fill()))
        self._lost |= self._connected.keys()

    def _connect(self, me: str, uri: str) -> None:
        """Subscribe again to what lost a publisher, and connect to those that answer."""
        ask: Any = MultiCall(self._master)
        tell: Any = MultiCall(limited_server(uri, ANSWER_LIMIT_S))
        kinds = dict(get_topic_manager().get_subscriptions())
        names = sorted(self._lost & kinds.keys())
        for name in names:
            ask.registerSubscriber(me, name, kinds[name], uri)
        # Each once: one that hangs can publish many topics.
        is_there = functools.lru_cache(maxsize=None)(
            lambda publisher: answers(publisher, me, ANSWER_LIMIT_S)
        )
        for name, publishers in zip(names, map(value_of, ask())):
            missing = [one for one in publishers if one not in self._connected[name]]
            if not missing:
                self._lost.discard(name)
            # rospy would wait without a limit for one that does not answer.
            found = list(filter(is_there, missing))
            if found:
                rospy.loginfo("connecting to %s again", name)
                # What a master does when publishers are new: rospy connects to them.
                tell.publisherUpdate(me, name, found)
        list(map(value_of, tell()))


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


def _leaves(tree: Dict[str, Any], above: str = "/") -> Iterator[Tuple[str, Any]]:
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{above}{name}/")
        else:
            yield above + name, value


class _Doorman:
    """Accepts connections in place of rospy's loop, in its thread, and waits for all headers."""

    def __init__(self, server: Any) -> None:
        self._server, self._begin = server, server.inbound_handler
        self._selector = selectors.DefaultSelector()
        server.inbound_handler = self._serve

    def note(self, address: Tuple[str, int]) -> None:
        """Log who was ended, such as a stranger or a node of a busy computer."""
        rospy.logwarn_throttle(
            SAY_PERIOD_S,
            "a connection from %s:%d that said nothing that ROS understands was ended; if it comes "
            "again, find the program that makes it, and end it",
            *address,
        )

    def _serve(self, first: socket.socket, address: Tuple[str, int]) -> None:
        """Be called by rospy with the next connection; return when the node ends."""
        listener: Any = self._server.server_sock
        listener.setblocking(False)
        listener.listen(MOST_OPEN)
        self._selector.register(listener, selectors.EVENT_READ)
        self._let_in(first, address)
        while not self._server.is_shutdown:
            for key, _events in self._selector.select(POLL_S):
                with contextlib.suppress(OSError):  # closed by the other end, or with the node
                    if key.data:
                        self._hear(key)
                    else:
                        self._let_in(*listener.accept())
            waiting = [key for key in self._selector.get_map().values() if key.data]
            for place, key in enumerate(waiting, MOST_OPEN - len(waiting)):
                if place < 0 or time.monotonic() > key.data[1]:
                    self._turn_away(key)

    def _let_in(self, connection: socket.socket, address: Tuple[str, int]) -> None:
        # It is readable when so many bytes have come, or when the other end has closed it.
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, LENGTH.size)
        data = address, time.monotonic() + HEADER_LIMIT_S
        self._selector.register(connection, selectors.EVENT_READ, data)

    def _hear(self, key: selectors.SelectorKey) -> None:
        connection: Any = key.fileobj
        head = connection.recv(LENGTH.size, socket.MSG_PEEK)
        size = LENGTH.size + LENGTH.unpack(head.ljust(LENGTH.size, b"\0"))[0]
        if not head:  # the other end has closed it
            self._selector.unregister(connection)
            connection.close()
        elif not LENGTH.size < size <= LARGEST_HEADER_BYTES:
            self._turn_away(key)
        elif connection.getsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT) < size:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, size)
        else:
            self._selector.unregister(connection)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, 1)
            self._begin(connection, key.data[0])

    def _turn_away(self, key: selectors.SelectorKey) -> None:
        self._selector.unregister(key.fileobj)
        self.note(key.data[0])
        key.fileobj.close()  # type: ignore[union-attr]


def _limit_requests(doorman: _Doorman) -> None:
    """Limit what is open to the XML-RPC of this process; who is cut off connects again."""
    opened: List[Tuple[socket.socket, Tuple[str, int]]] = []
    server_class: Any = ThreadingXMLRPCServer
    begin = server_class.process_request

    def process(server: Any, request: socket.socket, address: Tuple[str, int]) -> None:
        opened[:] = [one for one in (*opened, (request, address)) if one[0].fileno() >= 0]
        if len(opened) > MOST_OPEN:
            oldest, oldest_address = opened.pop(0)
            with contextlib.suppress(OSError):  # it has just ended
                oldest.shutdown(socket.SHUT_RDWR)
                doorman.note(oldest_address)
        begin(server, request, address)

    server_class.process_request = process
    SilenceableXMLRPCRequestHandler.timeout = HEADER_LIMIT_S
