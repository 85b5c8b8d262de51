"""Addresses and ROS masters: what is where, and whether it answers."""

from __future__ import annotations

import enum
import errno
import socket
from typing import FrozenSet, Tuple
from urllib.parse import urlsplit

from gpr20_common.low.links import NO_ANSWER, limited_server, value_of

CALLER = "/doctor"
# A master that lives answers within this time [s].
ANSWER_LIMIT_S = 2.0
# What offers both is the main control of a robot.
SERVICES = ("start_survey", "stop_survey")


class MasterState(enum.Enum):
    """Whether a master answers, and if not, what was found at its address."""

    ANSWERS = "answers"
    NOT_THERE = "nothing listens"
    HANGS = "something listens and does not answer"
    FOREIGN = "another program answers"
    UNKNOWN_HOST = "nobody knows the name of its computer"
    UNREACHABLE = "its computer is not reached"


def state_of(uri: str) -> MasterState:
    """Return whether the master of an address answers."""
    try:
        value_of(limited_server(uri, ANSWER_LIMIT_S).getPid(CALLER))
    except ConnectionRefusedError:
        return MasterState.NOT_THERE
    except OSError:
        return _without_answer(uri)
    except NO_ANSWER:
        return MasterState.FOREIGN
    return MasterState.ANSWERS


def _without_answer(uri: str) -> MasterState:
    parts = urlsplit(uri)
    if not addresses_of(parts.hostname or ""):
        return MasterState.UNKNOWN_HOST
    place = (parts.hostname or "", parts.port or 0)
    try:
        socket.create_connection(place, ANSWER_LIMIT_S).close()
    except OSError as error:
        refused = error.errno == errno.ECONNREFUSED
        return MasterState.NOT_THERE if refused else MasterState.UNREACHABLE
    return MasterState.HANGS


def is_here(name: str) -> bool:
    """Return whether a name or an IPv4 address is that of this computer."""
    return any(map(_is_own, addresses_of(name)))


def _is_own(address: str) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # Only an own address can be bound.
            probe.bind((address, 0))
        except OSError:
            return False
    return True


def addresses_of(name: str) -> FrozenSet[str]:
    """Return the IPv4 addresses of a name or address; none if nobody knows it."""
    try:
        return frozenset(str(one[4][0]) for one in socket.getaddrinfo(name, 0, socket.AF_INET))
    except (OSError, UnicodeError):
        return frozenset()


def robots_at(uri: str) -> Tuple[str, ...]:
    """Return the namespaces of the robots of a master, in their order; none if it is silent."""
    try:
        _publishers, _subscribers, services = value_of(
            limited_server(uri, ANSWER_LIMIT_S).getSystemState(CALLER)
        )
    except NO_ANSWER:
        return ()
    offered = [
        {name[: -len(one)] for name, _nodes in services if name.endswith(f"/{one}")}
        for one in SERVICES
    ]
    return tuple(sorted(space.rstrip("/") or "/" for space in set.intersection(*offered)))
