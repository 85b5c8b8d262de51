"""What is known of the nodes: who is missing, who is another than before."""

import threading

import pytest
from fake_clocks import ManualClock
from fake_robot import LIMIT_S

from gpr20_common.errors import NodeSilentError
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.node_book import START_LIMIT_S, NodeBook
from gpr20_main_control.mid.node_watcher import NodeWatcher


class Told:
    """A book of two nodes, and what it told."""

    def __init__(self):
        self.clock = ManualClock()
        self.sentences = []
        self.book = NodeBook(["x", "y"], self.clock, self.sentences.append, lambda: None)

    def all_alive(self):
        self.book.note_alive("x", 1)
        self.book.note_alive("y", 2)
        return self.book


def test_a_node_that_is_still_starting_is_not_called_missing():
    told = Told()
    told.book.note_silent("x")
    assert told.sentences == []
    told.clock.time_s += START_LIMIT_S + 1.0
    told.book.note_silent("x")
    assert told.sentences == ["x and y do not answer"]


def test_a_node_that_was_there_is_called_missing_at_once_and_its_return_is_told():
    told = Told()
    book = told.all_alive()
    book.note_silent("y")
    book.note_silent("y")
    book.note_alive("y", 3)
    assert told.sentences == ["y does not answer", ""]


def test_a_survey_cannot_go_on_with_a_node_that_is_missing():
    book = Told().all_alive()
    book.accept()
    book.check()
    book.note_silent("x")
    with pytest.raises(NodeLostError, match="x went silent"):
        book.check()


def test_a_node_that_was_started_anew_is_noticed_even_if_its_death_was_not():
    book = Told().all_alive()
    book.accept()
    book.note_alive("x", 17)
    with pytest.raises(NodeLostError, match="x started anew"):
        book.check()
    book.accept()
    book.check()


def test_both_kinds_of_loss_are_told_together():
    book = Told().all_alive()
    book.accept()
    book.note_alive("x", 17)
    book.note_silent("y")
    assert book.lost() == "y went silent, x started anew"


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
            raise NodeSilentError("gone")
        return self.pid


def test_a_refresh_returns_when_every_node_was_asked_after_it():
    probes = {"x": FakeProbe(), "y": FakeProbe()}
    watcher = NodeWatcher(probes, period_s=1000.0)
    book = NodeBook(watcher.names, ManualClock(), lambda sentence: None, watcher.refresh)
    watcher.start(book.note_alive, book.note_silent)
    book.refresh()
    assert book.missing() == []
    probes["y"].pid = None
    book.refresh()
    assert book.missing() == ["y"]
    watcher.stop()


def test_a_node_that_hangs_delays_no_other(monkeypatch):
    monkeypatch.setattr("gpr20_main_control.mid.node_watcher.REFRESH_LIMIT_S", 0.1)
    probes = {"x": FakeProbe(), "y": FakeProbe()}
    probes["x"].answering.clear()
    watcher = NodeWatcher(probes, period_s=1000.0)
    book = NodeBook(watcher.names, ManualClock(), lambda sentence: None, watcher.refresh)
    watcher.start(book.note_alive, book.note_silent)
    book.refresh()
    assert book.missing() == ["x"]
    probes["x"].answering.set()
    watcher.stop()
