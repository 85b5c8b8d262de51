"""What is known about the nodes: which are missing, which were restarted."""

import threading

import pytest
from fake_robot import LIMIT_S, ManualClock
from fault_kit import raises_fault

from gpr20_common.errors import NodeGoneError
from gpr20_common.faults import PART_SILENT
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.devices.node_liveness import (
    CONNECTIONS,
    SILENCE_LIMIT_S,
    START_LIMIT_S,
    NodeLiveness,
    WatchedNode,
)


class Watched:
    """Two nodes, and the messages about those that were missing."""

    def __init__(self):
        self.clock = ManualClock()
        self.reported = []
        nodes = {name: WatchedNode(verbatim(name), []) for name in ("x", "y")}
        self.nodes = NodeLiveness(nodes, self.clock, self._note)

    def _note(self, message):
        self.reported.append(message and message.all_details)
        assert message is None or message.fault_code == PART_SILENT.code

    def all_alive(self):
        self.nodes.note_alive("x", 1)
        self.nodes.note_alive("y", 2)
        return self.nodes


def test_a_node_is_called_missing_at_once_if_it_was_there_and_otherwise_when_it_had_its_time():
    bench = Watched()
    bench.nodes.note_silent("x")
    assert bench.reported == []
    bench.clock.time_s += START_LIMIT_S + 1.0
    bench.nodes.note_silent("x")
    assert bench.reported == [("x", "y")]
    nodes = bench.all_alive()
    nodes.note_silent("y")
    nodes.note_silent("y")
    nodes.note_alive("y", 3)
    assert bench.reported[-2:] == [("y",), None]


def test_a_survey_cannot_go_on_with_a_node_that_is_missing_or_was_started_anew():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.check()
    # It is noticed even if its death was not.
    nodes.note_alive("x", 17)
    with raises_fault(PART_SILENT, "(x)", error=NodeLostError):
        nodes.check()
    nodes.note_silent("y")
    assert nodes.lost().all_details == ("y", "x")
    nodes.note_alive("y", 2)
    nodes.accept()
    nodes.check()


class FakeProbe:
    """A node that answers, is silent, or hangs until it is released."""

    def __init__(self):
        self.pid = 5
        self.asked = 0
        self.answering = threading.Event()
        self.answering.set()

    def process(self):
        self.asked += 1
        assert self.answering.wait(LIMIT_S)
        if self.pid is None:
            raise NodeGoneError(verbatim("gone"))
        return self.pid


@pytest.fixture
def liveness():
    """Return what begins to ask nodes, over one or more connections each."""
    begun = []

    def begin(period_s, **connections):
        asked = {
            name: WatchedNode(verbatim(name), [one.process for one in probes])
            for name, probes in connections.items()
        }
        nodes = NodeLiveness(asked, Clock(), lambda _sentence: None, period_s=period_s)
        nodes.start()
        begun.append((nodes, connections))
        return nodes

    yield begin
    for nodes, connections in begun:
        for probes in connections.values():
            for one in probes:
                one.answering.set()
        nodes.stop()


def test_a_refresh_returns_when_every_node_was_asked_after_it(liveness):
    x, y = FakeProbe(), FakeProbe()
    nodes = liveness(1000.0, x=[x], y=[y])
    nodes.refresh()
    assert nodes.missing() == []
    y.pid = None
    nodes.refresh()
    assert nodes.missing() == ["y"]


def test_a_node_that_hangs_delays_no_other(liveness, monkeypatch):
    monkeypatch.setattr("gpr20_main_control.mid.devices.node_liveness.REFRESH_LIMIT_S", 0.1)
    x = FakeProbe()
    x.answering.clear()
    nodes = liveness(1000.0, x=[x], y=[FakeProbe()])
    nodes.refresh()
    assert nodes.missing() == ["x"]


def test_a_node_with_one_connection_that_hangs_is_asked_over_the_others(liveness):
    hanging = FakeProbe()
    hanging.answering.clear()
    nodes = liveness(0.001, x=[hanging, FakeProbe()])
    for _time in range(3):
        nodes.refresh()
        assert nodes.missing() == []


class AskedOften(FakeProbe):
    """A node that answers, and has been asked so often that all others had their turns."""

    def __init__(self):
        super().__init__()
        self.often = threading.Event()

    def process(self):
        if self.asked > 100:
            self.often.set()
        return super().process()


def test_nodes_that_hang_never_hold_the_last_thread_that_asks(liveness):
    hanging = {name: [FakeProbe() for _one in range(CONNECTIONS)] for name in "abcdef"}
    for probes in hanging.values():
        for one in probes:
            one.answering.clear()
    alive = AskedOften()
    nodes = liveness(0.001, **hanging, y=[alive])
    assert alive.often.wait(LIMIT_S)
    assert nodes.missing() == list("abcdef")


def test_an_answer_that_is_late_is_no_lost_node_and_silence_is_one():
    bench = Watched()
    nodes = bench.all_alive()
    nodes.accept()
    bench.clock.time_s += SILENCE_LIMIT_S
    nodes.note_late("y")
    nodes.check()
    assert bench.reported == []
    bench.clock.time_s += 0.1
    nodes.note_late("y")
    with raises_fault(PART_SILENT, "(y)", error=NodeLostError):
        nodes.check()
    assert bench.reported == [("y",)]


class Overtaken:
    """Two connections to a node: one brings an answer from before the node's end."""

    def __init__(self):
        self.asked, self.ended = threading.Event(), threading.Event()
        self.delivered = threading.Event()

    def slow(self):
        if self.asked.is_set():
            assert self.ended.wait(LIMIT_S)
            self.delivered.set()
            raise NodeGoneError(verbatim("gone"))
        self.asked.set()
        assert self.ended.wait(LIMIT_S)
        return 5

    def fast(self):
        assert self.asked.wait(LIMIT_S)
        raise NodeGoneError(verbatim("gone"))


def test_an_answer_from_before_the_end_of_a_node_does_not_revive_it():
    probes = Overtaken()
    said = []
    node = WatchedNode(Message("the node"), [probes.slow, probes.fast])
    nodes = NodeLiveness({"x": node}, Clock(), said.append, period_s=0.001)
    nodes.start()
    assert probes.asked.wait(LIMIT_S)
    nodes.refresh()
    probes.ended.set()
    assert probes.delivered.wait(LIMIT_S)
    nodes.stop()
    assert nodes.missing() == ["x"]
    assert None not in said
