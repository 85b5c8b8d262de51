"""What is known about the nodes: which are missing, which were restarted."""

import threading

import pytest
from fake_robot import LIMIT_S, ManualClock
from fault_kit import raises_fault

from gpr20_common.errors import NodeGoneError, NodeSilentError
from gpr20_common.faults import PART_SILENT
from gpr20_common.low.clock import Clock
from gpr20_common.message import verbatim
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.devices.node_liveness import START_LIMIT_S, NodeLiveness


class Watched:
    """Two nodes that a test notes, and the messages about those that were missing."""

    def __init__(self):
        self.clock = ManualClock()
        self.reported = []
        self.nodes = NodeLiveness(self.clock, self._note)
        for name in ("x", "y"):
            self.nodes.watch(name, verbatim(name), None)

    def _note(self, message):
        self.reported.append(message and message.all_details)
        assert message is None or message.fault_code == PART_SILENT.code

    def all_alive(self):
        self.nodes.note("x", 1)
        self.nodes.note("y", 2)
        return self.nodes


def test_a_node_is_called_missing_at_once_if_it_was_there_and_otherwise_when_it_had_its_time():
    bench = Watched()
    bench.nodes.note("x", None)
    assert bench.reported == []
    bench.clock.time_s += START_LIMIT_S + 1.0
    bench.nodes.note("x", None)
    assert bench.reported == [("x", "y")]
    nodes = bench.all_alive()
    nodes.note("y", None)
    nodes.note("y", None)
    nodes.note("y", 3)
    assert bench.reported == [("x", "y"), ("y",), None, ("y",), None]


def test_a_node_that_was_restarted_is_lost_until_it_is_accepted():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.check()
    nodes.note("x", 17)
    with raises_fault(PART_SILENT, "(x)", error=NodeLostError):
        nodes.check()
    nodes.note("y", None)
    assert nodes.lost().all_details == ("y", "x")
    nodes.note("y", 2)
    nodes.accept()
    nodes.check()


class FakeNode:
    """A node that answers, is silent, or hangs until it is released."""

    def __init__(self):
        self.answer = 5
        self.answering = threading.Event()
        self.answering.set()

    def process(self):
        answer = self.answer
        assert self.answering.wait(LIMIT_S)
        if isinstance(answer, Exception):
            raise answer
        return answer


@pytest.fixture
def watch():
    """Return what begins to watch nodes, which are asked once unless they are asked for."""
    begun = []

    def begin(**watched):
        nodes = NodeLiveness(Clock(), lambda _message: None, period_s=1000.0)
        for name, node in watched.items():
            nodes.watch(name, verbatim(name), node.process)
        begun.append((nodes, watched))
        return nodes

    yield begin
    for nodes, watched in begun:
        nodes.stop()
        for node in watched.values():
            node.answering.set()


@pytest.mark.parametrize("failure", [NodeGoneError, NodeSilentError])
def test_a_refresh_returns_when_every_node_was_asked_after_it(watch, failure):
    x, y = FakeNode(), FakeNode()
    nodes = watch(x=x, y=y)
    for answer, missing in ((5, []), (failure(verbatim("no answer")), ["y"]), (6, [])):
        y.answer = answer
        nodes.refresh()
        assert nodes.missing() == missing


def test_nodes_that_hang_delay_no_other_and_an_answer_from_before_a_refresh_does_not_count(watch):
    hanging, alive = {name: FakeNode() for name in "abcdef"}, FakeNode()
    for node in hanging.values():
        node.answering.clear()
    nodes = watch(**hanging, y=alive)
    refreshed = threading.Event()
    refreshing = threading.Thread(target=lambda: (nodes.refresh(), refreshed.set()))
    refreshing.start()
    # Not when it is asked, but when it answers: "a" has ended since.
    hanging["a"].answer = NodeGoneError(verbatim("gone"))
    assert not refreshed.is_set()
    for node in hanging.values():
        node.answering.set()
    assert refreshed.wait(LIMIT_S)
    assert nodes.missing() == ["a"]
