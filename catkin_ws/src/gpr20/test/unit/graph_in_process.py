"""The services and topics of nodes without a master: handlers that take real messages."""

from __future__ import annotations

import io
from collections import defaultdict

import pytest

pytest.importorskip("rospy")

import rospy

from gpr20_common.high.diagnostics import Diagnostics
from gpr20_common.high.periodic import Periodic


class Graph:
    """What nodes of this process have advertised and published.

    Attributes:
        services: The classes and handlers, by name.
        published: The messages of each topic.
        hooks: What is called when the nodes shut down.
        ticks: What the nodes do periodically.
        health: What the node that was made last says in its diagnostics.
    """

    def __init__(self, monkeypatch):
        self.services, self.published = {}, defaultdict(list)
        self.hooks, self.ticks, self.health = [], [], None
        graph = self

        class Publisher:
            def __init__(self, name, _kind, **_options):
                self.name = self.resolved_name = name

            def get_num_connections(self):
                return 1

            def publish(self, message):
                graph.published[self.name].append(message)

        def advertise(name, kind, handler):
            self.services[name] = kind, handler

        for module, name, stand_in in (
            (rospy, "Service", advertise),
            (rospy, "Publisher", Publisher),
            (rospy, "on_shutdown", self.hooks.append),
            (rospy.Time, "now", rospy.Time),
            (Diagnostics, "__init__", lambda _own, _name, health: setattr(self, "health", health)),
            (Periodic, "__init__", lambda _own, _period_s, tick: self.ticks.append(tick)),
        ):
            monkeypatch.setattr(module, name, stand_in)

    def ask(self, name, request=None, client="/client", **fields):
        """Return the answer of a service to what a client sends."""
        kind, handler = self.services[name]
        request = kind._request_class(**fields) if request is None else request
        received = kind._request_class()
        received.deserialize(sent(request))
        received._connection_header = {"callerid": client}
        answer = handler(received)
        sent(answer)
        return answer


def sent(message):
    """Return the bytes of a message."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()
