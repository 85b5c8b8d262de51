"""A class of another package whose calls never return holds nothing up."""

from __future__ import annotations

import contextlib
import threading
import time

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from toy_vna import ADDRESS, MAKER, MODEL, ToyInstrument

from gpr20_common.low.clock import Clock
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaError, VnaTimeoutError
from gpr20_vna_acquisition.mid import foreign_analyzer
from gpr20_vna_acquisition.mid.foreign_analyzer import make_foreign_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SWEEP = SweepSettings(600e6, 6e9, 51)
# A request ends this long after its limit at the latest [s]; measured: 1.1 s.
LATEST_S = 2.5
# Limits that nobody waits for.
PATIENT = {"request_timeout_s": 60.0, "sweep_timeout_s": 60.0, "answer_timeout_s": 60.0}


class Bench:
    """A driver with a class at a simulated instrument."""

    def __init__(self, blocks: str = "", **parameters) -> None:
        self.instrument = ToyInstrument()
        values = {
            "analyzer": "toy_vna:ToyVna",
            "analyzer_options": {"instrument": self.instrument, "blocks": blocks},
            "maker": MAKER,
            "model": MODEL,
            "connect_timeout_s": 0.1,
            "answer_timeout_s": 0.1,
            "sweep_timeout_s": 0.1,
            "request_timeout_s": 0.5,
            "retry_pause_s": 0.01,
            **parameters,
        }
        self.parameters = VnaParameters(**values)
        deadline = RequestDeadline(Clock())
        self.analyzer = make_foreign_analyzer(self.parameters, deadline)
        self.driver = VNADriver(self.analyzer, self.parameters, deadline, lambda _text: None)

    def set_up(self) -> Bench:
        self.driver.connect_to_vna(ADDRESS)
        self.driver.set_frequency_sweep(SWEEP)
        return self

    def block(self, call: str) -> None:
        """Let the present object block; later ones do not."""
        self.instrument.made[-1].blocks = call
        self.parameters.analyzer_options["blocks"] = ""

    def begin_trace(self) -> None:
        """Request a trace that blocks; return when it does."""

        def trace() -> None:
            with contextlib.suppress(VnaError):
                self.driver.get_trace()

        threading.Thread(target=trace, daemon=True).start()
        assert self.instrument.made[-1].blocking.wait(LATEST_S)

    def end(self) -> None:
        for one in self.instrument.made:
            one.freed.set()


@pytest.fixture
def bench():
    bench = Bench()
    yield bench.set_up()
    bench.end()


def in_time(action) -> float:
    """Do something in a thread of its own, which a hanging class may hold; return how long."""
    begun_s = time.monotonic()
    thread = threading.Thread(target=action, daemon=True)
    thread.start()
    thread.join(LATEST_S + 0.5)
    assert not thread.is_alive(), "it is held up"
    return time.monotonic() - begun_s


def failure_of(action, *arguments):
    """Return how a request fails, in time."""
    failures = []

    def run() -> None:
        try:
            action(*arguments)
        except VnaError as error:
            failures.append(error)

    in_time(run)
    return failures[0]


@each_case("blocks", ["connect", "identify"])
def test_connecting_to_a_class_that_blocks_fails_in_time(blocks):
    bench = Bench(blocks)
    error = failure_of(bench.driver.connect_to_vna, ADDRESS)
    assert error.message.fault_code in (faults.TOO_SLOW.code, faults.NO_ANSWER.code)
    assert bench.driver.trouble is not None
    bench.end()


@each_case("call", ["sweep", "confirm", "calibration"])
def test_a_trace_is_made_with_a_new_object_when_the_class_blocks(call):
    bench = Bench(request_timeout_s=4.0).set_up()
    bench.block(call)
    sweeps = []
    in_time(lambda: sweeps.append(bench.driver.get_trace()))
    assert len(sweeps) == 1 and len(bench.instrument.made) == 2
    assert bench.driver.state.repeats == 1
    bench.end()


def test_a_class_that_always_blocks_fails_the_trace_in_time(bench):
    bench.instrument.made[-1].blocks = bench.parameters.analyzer_options["blocks"] = "sweep"
    error = failure_of(bench.driver.get_trace)
    assert isinstance(error, VnaTimeoutError)
    assert error.message.fault_code in (faults.TOO_SLOW.code, faults.NO_ANSWER.code)


@each_case("call", ["configure", "check_sweep"])
def test_a_set_up_that_blocks_fails_in_time(call):
    bench = Bench().set_up()
    bench.block(call)
    assert failure_of(bench.driver.set_frequency_sweep, SWEEP)
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.set_frequency_sweep(SWEEP).points == SWEEP.points
    bench.end()


def test_what_an_abandoned_call_returns_late_never_counts(bench):
    first = bench.instrument.made[0]
    first.blocks, first.trace_duration_s = "sweep", 77.0
    bench.parameters.analyzer_options["blocks"] = ""
    failure_of(bench.driver.get_trace)
    bench.driver.connect_to_vna(ADDRESS)
    bench.driver.set_frequency_sweep(SWEEP)
    number, _sweep = bench.driver.take_sweep()
    first.freed.set()
    with raises_fault(faults.SUPERSEDED, error=VnaTimeoutError):
        while True:
            first.deadline.pause_s(0.001)
    assert bench.driver.trace_duration_s < 1.0
    bench.driver.confirm(number)


@each_case(
    "call, end",
    [
        ("sweep", "shut_down"),
        ("confirm", "disconnect_from_vna"),
        ("release", "shut_down"),
        ("disconnect", "disconnect_from_vna"),
    ],
)
def test_shutdown_and_disconnection_are_not_held_up(call, end):
    bench = Bench(**PATIENT).set_up()
    bench.block(call)
    if call in ("sweep", "confirm"):
        bench.begin_trace()
    in_time(getattr(bench.driver, end))
    bench.end()


def test_a_later_connection_ends_a_call_that_blocks():
    bench = Bench(**PATIENT).set_up()
    bench.block("sweep")
    bench.begin_trace()
    in_time(lambda: bench.driver.connect_to_vna(ADDRESS))
    assert bench.driver.vna_connected and len(bench.instrument.made) == 2
    bench.end()


def test_calls_that_never_end_are_bounded(monkeypatch):
    monkeypatch.setattr(foreign_analyzer, "MOST_ABANDONED", 2)
    bench = Bench("connect", request_timeout_s=0.1)
    for _ in range(2):
        failure_of(bench.driver.connect_to_vna, ADDRESS)
    stuck = failure_of(bench.driver.connect_to_vna, ADDRESS)
    assert stuck.message.cause == faults.CLASS_STUCK
    assert len(bench.instrument.made) == 2
    bench.parameters.analyzer_options["blocks"] = ""
    bench.end()
    deadline_s = time.monotonic() + LATEST_S
    while not bench.driver.vna_connected and time.monotonic() < deadline_s:
        with contextlib.suppress(VnaError):
            bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.vna_connected


def test_a_class_whose_constructor_blocks_is_refused_in_time():
    in_time(lambda: failure_of(lambda: Bench(analyzer="test_hung_analyzer:NeverMade")))


class NeverMade:
    """Blocks while it is made."""

    trace_duration_s, remarks = None, ()

    def __init__(self, *_arguments, **_options):
        threading.Event().wait()

    connect = identify = configure = sweep = confirm = calibration = release = disconnect = None
    check_sweep = None
