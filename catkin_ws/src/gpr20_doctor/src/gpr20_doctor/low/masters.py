"""ROS masters: whether they answer, which robots they have, and whether their nodes answer."""

from __future__ import annotations

import enum
import errno
import socket
from concurrent.futures import ThreadPoolExecutor
from typing import Dict, FrozenSet, Iterable, Tuple
from urllib.parse import urlsplit

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.low.links import NO_ANSWER, NodeProbe, limited_server, value_of
from gpr20_doctor.low.network import addresses_of

CALLER = "/doctor"
# A master or a node that lives answers within this time [s].
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


class NodeState(enum.Enum):
    """What the master and the node itself say of a node."""

    ANSWERS = "answers"
    HANGS = "is registered and does not answer"
    GONE = "has ended, or was never started"


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


def robots_on_master(services: Iterable[str]) -> FrozenSet[str]:
    """Return the namespaces of the robots, from the full names of all services."""
    names = set(services)
    first = SERVICES[0]
    spaces = {name[: -len(first)] for name in names if name.endswith(f"/{first}")}
    return frozenset(
        space.rstrip("/") or "/"
        for space in spaces
        if all(f"{space}{service}" in names for service in SERVICES)
    )


def robots_at(uri: str) -> Tuple[str, ...]:
    """Return the namespaces of the robots of a master, in their order; none if it is silent."""
    try:
        _publishers, _subscribers, services = value_of(
            limited_server(uri, ANSWER_LIMIT_S).getSystemState(CALLER)
        )
        return tuple(sorted(robots_on_master(name for name, _nodes in services)))
    except NO_ANSWER:
        return ()


def node_states(uri: str, names: Iterable[str]) -> Dict[str, NodeState]:
    """Ask nodes, all at once.

    Args:
        uri: A master that answers.
        names: Full names of the nodes.
    """

    def ask(name: str) -> NodeState:
        try:
            NodeProbe(uri, CALLER, name, ANSWER_LIMIT_S).process()
        except NodeGoneError:
            return NodeState.GONE
        except NodeSilentError:
            return NodeState.HANGS
        return NodeState.ANSWERS

    asked = list(names)
    with ThreadPoolExecutor(max(1, len(asked))) as pool:
        return dict(zip(asked, pool.map(ask, asked)))
