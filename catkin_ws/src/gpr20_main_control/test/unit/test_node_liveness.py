"""What is known about the nodes: which are missing, which were restarted."""

import threading

import pytest
from fake_clocks import ManualClock
from fake_robot import LIMIT_S

from gpr20_common.errors import NodeGoneError
from gpr20_common.message import Message, verbatim
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.node_liveness import START_LIMIT_S, NodeLiveness, WatchedNode


def watched(probe=None, name="x"):
    return WatchedNode(Message("the {axis} axis driver", axis=name), [probe])


class Watched:
    """Two nodes, and the messages about those that were missing."""

    def __init__(self):
        self.clock = ManualClock()
        self.sentences = []
        nodes = {name: watched(name=name) for name in ("x", "y")}
        self.nodes = NodeLiveness(nodes, self.clock, self._note)

    def _note(self, message):
        self.sentences.append(message and str(message))

    def all_alive(self):
        self.nodes.note_alive("x", 1)
        self.nodes.note_alive("y", 2)
        return self.nodes


def test_a_node_that_is_still_starting_is_not_called_missing():
    bench = Watched()
    bench.nodes.note_silent("x")
    assert bench.sentences == []
    bench.clock.time_s += START_LIMIT_S + 1.0
    bench.nodes.note_silent("x")
    assert bench.sentences == [
        "the x axis driver does not answer; the y axis driver does not answer (x; y)"
    ]


def test_a_node_that_was_there_is_called_missing_at_once_and_its_return_is_told():
    bench = Watched()
    nodes = bench.all_alive()
    nodes.note_silent("y")
    nodes.note_silent("y")
    nodes.note_alive("y", 3)
    assert bench.sentences == ["the y axis driver does not answer (y)", None]


def test_a_survey_cannot_go_on_with_a_node_that_is_missing():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.check()
    nodes.note_silent("x")
    with pytest.raises(NodeLostError, match="the x axis driver stopped answering"):
        nodes.check()


def test_a_node_that_was_started_anew_is_noticed_even_if_its_death_was_not():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.note_alive("x", 17)
    with pytest.raises(NodeLostError, match="the x axis driver restarted"):
        nodes.check()
    nodes.accept()
    nodes.check()


def test_both_kinds_of_loss_are_told_together():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.note_alive("x", 17)
    nodes.note_silent("y")
    lost = nodes.lost()
    assert lost.sentence() == "the y axis driver stopped answering; the x axis driver restarted"
    assert lost.all_details == ("y", "x")


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


def liveness_of(probes):
    """Begin to ask nodes, each once and then only for a refresh."""
    asked = {name: watched(probe.process, name) for name, probe in probes.items()}
    nodes = NodeLiveness(asked, ManualClock(), lambda sentence: None, period_s=1000.0)
    nodes.start()
    return nodes


def test_a_refresh_returns_when_every_node_was_asked_after_it():
    probes = {"x": FakeProbe(), "y": FakeProbe()}
    nodes = liveness_of(probes)
    nodes.refresh()
    assert nodes.missing() == []
    probes["y"].pid = None
    nodes.refresh()
    assert nodes.missing() == ["y"]
    nodes.stop()


def test_a_node_that_hangs_delays_no_other(monkeypatch):
    monkeypatch.setattr("gpr20_main_control.mid.node_liveness.REFRESH_LIMIT_S", 0.1)
    probes = {"x": FakeProbe(), "y": FakeProbe()}
    probes["x"].answering.clear()
    nodes = liveness_of(probes)
    nodes.refresh()
    assert nodes.missing() == ["x"]
    probes["x"].answering.set()
    nodes.stop()
