"""In place of the topics and services of a ROS graph."""

import queue
import threading
from types import SimpleNamespace

from gpr20_common.high.answers import message_fields
from gpr20_common.message import verbatim

LIMIT_S = 100.0


class Graph:
    """Delivers the messages that a test sends to whoever listens."""

    def __init__(self):
        self.subscribers = []

    def subscriber(self, name, _kind, received, callback_args=None, queue_size=None):
        given = () if callback_args is None else (callback_args,)
        one = SimpleNamespace(name=name, received=lambda message: received(message, *given))
        one.unregister = lambda: self.subscribers.remove(one)
        self.subscribers.append(one)
        return one

    def send(self, sender, topic, message):
        message._connection_header = {"callerid": sender}
        for one in [one for one in self.subscribers if one.name == topic]:
            one.received(message)


class Services:
    """Answers calls as a test says.

    Attributes:
        answers: Of each service, one after the other, the last again and again: its fields, an
            error, or `hung`, before the next one.
        usual: What a service without answers of its own says.
        asked: The name of each service that was called, with the fields of the call.
        hung: What a service waits for that hangs.
    """

    def __init__(self):
        self.answers, self.usual = {}, {}
        self.asked, self.hung = queue.Queue(), threading.Event()

    def call(self, client, _timeout_s, **fields):
        self.asked.put((client.name, fields))
        answer = self._next(client.name)
        if answer is self.hung:
            assert self.hung.wait(LIMIT_S)
            answer = self._next(client.name)
        if isinstance(answer, Exception):
            raise answer
        said = message_fields(verbatim("as it is"))
        return SimpleNamespace(**{"success": True, **said, **answer})

    def _next(self, name):
        answers = self.answers.get(name, [self.usual])
        return answers.pop(0) if len(answers) > 1 else answers[0]


def taken(events, count):
    return [events.get(timeout=LIMIT_S) for _ in range(count)]
