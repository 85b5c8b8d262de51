"""A class of another package whose calls never return holds nothing up."""

from __future__ import annotations

import contextlib
import threading
import time

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from toy_vna import ADDRESS, MAKER, MODEL, ToyInstrument

from gpr20_common.faults import BUSY, INTERNAL
from gpr20_common.low.clock import Clock
from gpr20_survey.faults import VNA_SILENT
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaError, VnaTimeoutError
from gpr20_vna_acquisition.mid import analyzer_instance, foreign_analyzer
from gpr20_vna_acquisition.mid.foreign_analyzer import make_foreign_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SWEEP = SweepSettings(600e6, 6e9, 51)
# What ends only because a call was given up, ends long before this on a busy machine, too [s].
LIMIT_S = 30.0
# Limits that nobody waits for.
PATIENT = {"request_timeout_s": 600.0, "sweep_timeout_s": 600.0, "answer_timeout_s": 600.0}
GIVEN_UP = (VNA_SILENT.code, VNA_SILENT.code)


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
            "request_timeout_s": 1.0,
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
        assert self.instrument.made[-1].blocking.wait(LIMIT_S)


@pytest.fixture
def make(monkeypatch):
    """Make benches whose classes may go on in the end."""
    monkeypatch.setattr(foreign_analyzer, "STEP_MARGIN_S", 0.1)
    monkeypatch.setattr(foreign_analyzer, "LAST_CALL_S", 0.1)
    monkeypatch.setattr(analyzer_instance, "OWN_END_S", 0.1)
    made = []

    def make_bench(*arguments, **parameters):
        made.append(Bench(*arguments, **parameters))
        return made[-1]

    yield make_bench
    for bench in made:
        for one in bench.instrument.made:
            one.freed.set()


def failure_of(action, *arguments):
    """Return how a request fails; one that hangs ends with the time limit of the test."""
    with pytest.raises(VnaError) as failed:
        action(*arguments)
    return failed.value


@each_case("blocks", ["connect", "identify"])
def test_connecting_to_a_class_that_blocks_fails_in_time(make, blocks):
    bench = make(blocks)
    error = failure_of(bench.driver.connect_to_vna, ADDRESS)
    assert error.message.fault_code in GIVEN_UP
    assert bench.driver.trouble is not None


@each_case("call", ["sweep", "confirm", "calibration"])
def test_a_trace_is_made_with_a_new_object_when_the_class_blocks(make, call):
    bench = make(request_timeout_s=LIMIT_S).set_up()
    bench.block(call)
    assert len(bench.driver.get_trace().s21_real) == SWEEP.points
    assert len(bench.instrument.made) >= 2
    assert bench.driver.state.repeats >= 1


def test_a_class_that_always_blocks_fails_the_trace_in_time(make):
    bench = make().set_up()
    bench.instrument.made[-1].blocks = bench.parameters.analyzer_options["blocks"] = "sweep"
    error = failure_of(bench.driver.get_trace)
    assert isinstance(error, VnaTimeoutError) and error.message.fault_code in GIVEN_UP


@each_case("call", ["configure", "check_sweep"])
def test_a_set_up_that_blocks_fails_in_time(make, call):
    bench = make().set_up()
    bench.block(call)
    assert failure_of(bench.driver.set_frequency_sweep, SWEEP)
    assert bench.set_up().driver.state.sweep.points == SWEEP.points


def test_what_an_abandoned_call_returns_late_never_counts(make):
    bench = make().set_up()
    first = bench.instrument.made[0]
    first.trace_duration_s = 77.0
    first.blocks = bench.parameters.analyzer_options["blocks"] = "sweep"
    failure_of(bench.driver.get_trace)
    bench.parameters.analyzer_options["blocks"] = ""
    number, _sweep = bench.set_up().driver.take_sweep()
    first.freed.set()
    with raises_fault(BUSY, error=VnaTimeoutError):
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
def test_shutdown_and_disconnection_are_not_held_up(make, call, end):
    bench = make(**PATIENT).set_up()
    bench.block(call)
    if call in ("sweep", "confirm"):
        bench.begin_trace()
    getattr(bench.driver, end)()


def test_calls_that_never_end_are_bounded(make, monkeypatch):
    monkeypatch.setattr(foreign_analyzer, "MOST_ABANDONED", 2)
    bench = make("connect", request_timeout_s=0.1)
    for _ in range(2):
        failure_of(bench.driver.connect_to_vna, ADDRESS)
    stuck = failure_of(bench.driver.connect_to_vna, ADDRESS)
    assert stuck.message.cause == INTERNAL
    assert len(bench.instrument.made) == 2
    # They do end.
    bench.parameters.analyzer_options["blocks"] = ""
    for one in bench.instrument.made:
        one.freed.set()
    deadline_s = time.monotonic() + LIMIT_S
    while not bench.driver.vna_connected:
        assert time.monotonic() < deadline_s
        with contextlib.suppress(VnaError):
            bench.driver.connect_to_vna(ADDRESS)


class NeverMade:
    """Blocks while it is made."""

    trace_duration_s, remarks = None, ()

    def __init__(self, *_arguments, **_options):
        threading.Event().wait()

    connect = identify = configure = sweep = confirm = calibration = release = disconnect = None
    check_sweep = None


def test_a_class_whose_constructor_blocks_is_refused_in_time(make):
    assert failure_of(lambda: make(analyzer="test_hung_analyzer:NeverMade"))
