"""In place of the topics of a ROS graph."""

from types import SimpleNamespace


class Graph:
    """Delivers the messages that a test sends.

    Attributes:
        subscribers: Whoever listens, with its topic.
        connected: How many publishers each of them has.
    """

    def __init__(self):
        self.subscribers, self.connected = [], 0

    def subscriber(self, name, _kind, received, callback_args=None, queue_size=None):
        given = () if callback_args is None else (callback_args,)
        one = SimpleNamespace(name=name, received=lambda message: received(message, *given))
        one.get_num_connections = lambda: self.connected
        one.unregister = lambda: self.subscribers.remove(one)
        self.subscribers.append(one)
        return one

    def send(self, sender, topic, message):
        message._connection_header = {"callerid": sender}
        for one in [one for one in self.subscribers if one.name == topic]:
            one.received(message)
