"""Calls that a survey gave up and that reach their node later: they change nothing."""

import threading
import time

import pytest
from fake_robot import LIMIT_S, NODES, Bench, FakeAnalyzer, FakeStorage

from gpr20_common.message import Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.waits import SerialCalls
from gpr20_survey.plan.survey_state import SurveyState as State

VNA = "vna_acquisition"


class ForgetfulAnalyzer(FakeAnalyzer):
    """Forgets its sweep when it is connected, as the node does; a call may wait for its node.

    `wait_in` names a call that is held, once, until `node_is_back`.
    """

    def __init__(self):
        super().__init__()
        self.wait_in = ""
        self.waiting = threading.Event()
        self.node_is_back = threading.Event()
        self.late_calls_end = lambda: None

    def _reach_node(self, name):
        if self.wait_in == name:
            self.wait_in = ""
            self.waiting.set()
            self.node_is_back.wait(LIMIT_S)

    def connect(self, address):
        self._reach_node("connect")
        self._settings = None
        return super().connect(address)

    def frequencies_hz(self):
        self.late_calls_end()
        if self._settings is None:
            raise DeviceError(Message("no sweep is configured"))
        return super().frequencies_hz()


def wait_until(condition):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, "the condition did not come true in time"
        time.sleep(0.01)


@pytest.fixture
def bench():
    bench = Bench(return_limit_s=3600.0, analyzer=ForgetfulAnalyzer())
    yield bench
    bench.analyzer.node_is_back.set()
    bench.release()
    bench.control.shut_down(LIMIT_S)


def release_between_setup_and_question(bench):
    """Let the held call reach its node after the new sweep was set up, if that is possible."""
    analyzer = bench.analyzer
    connections = len(analyzer.connections)

    def late_calls_end():
        analyzer.late_calls_end = lambda: None
        analyzer.node_is_back.set()
        # The new call and the late one.
        wait_until(lambda: len(analyzer.connections) == connections + 2)

    analyzer.late_calls_end = late_calls_end
    # If the new calls wait for the late one, the frequencies are not read before it ends.
    threading.Timer(0.3, analyzer.node_is_back.set).start()


def test_a_connection_that_was_given_up_does_not_undo_the_next_one(bench):
    bench.analyzer.failures = 1
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.analyzer.wait_in = "connect"
    bench.control.resume("")
    assert bench.analyzer.waiting.wait(LIMIT_S)
    bench.nodes.note_silent(VNA)
    bench.wait_for_fault(faults.WAITING_FOR_PART, NODES[VNA])
    release_between_setup_and_question(bench)
    bench.nodes.note_alive(VNA, 2)
    bench.complete()
    assert bench.states.count(State.PAUSED.name) == 1


def test_a_call_that_was_given_up_before_its_turn_is_never_made():
    calls = SerialCalls()
    begun, go_on = threading.Event(), threading.Event()
    made = []

    def first():
        begun.set()
        go_on.wait(LIMIT_S)
        made.append("first")

    def give_up():
        if begun.is_set():
            raise DeviceError(Message("given up"))

    with pytest.raises(DeviceError):
        calls.call(first, give_up)
    with pytest.raises(DeviceError):
        calls.call(lambda: made.append("second"), give_up)
    go_on.set()
    calls.call(lambda: made.append("third"), lambda: None)
    assert made == ["first", "third"]


class SlowStorage(FakeStorage):
    """The first survey is opened only when `node_is_back`."""

    def __init__(self):
        super().__init__()
        self.waiting, self.node_is_back = threading.Event(), threading.Event()

    def open(self, record):
        if not self.waiting.is_set():
            self.waiting.set()
            self.node_is_back.wait(LIMIT_S)
        return super().open(record)


def test_a_survey_that_was_stopped_before_it_was_open_is_never_opened_after_the_next():
    storage = SlowStorage()
    bench = Bench(storage=storage)
    bench.start()
    assert storage.waiting.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    threading.Timer(0.3, storage.node_is_back.set).start()
    survey_id = bench.control.start()
    bench.complete()
    wait_until(lambda: len(storage.records) == 2)
    assert storage.records[-1].survey_id == survey_id
    bench.control.shut_down(LIMIT_S)
