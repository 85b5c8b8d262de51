"""A call of a class of another package that does not return ends the process of the driver."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from driver_bench import FakeClock
from toy_vna import ADDRESS, MAKER, MODEL, ToyInstrument

from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import VnaClosedError, VnaError
from gpr20_vna_acquisition.mid import vna_driver
from gpr20_vna_acquisition.mid.analyzers import make_foreign_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SWEEP = SweepSettings(600e6, 6e9, 51)
# What ends only because a call was given up, ends long before this on a busy machine, too [s].
LIMIT_S = 30.0
# 3 connect_timeout_s, 2 answer_timeout_s, and 1.5 s.
USUAL_S = 20.5


class Bench:
    """A driver with a class at a simulated instrument, whose time stands still."""

    def __init__(self) -> None:
        self.instrument, self.clock = ToyInstrument(), FakeClock()
        options = {"instrument": self.instrument}
        parameters = VnaParameters(
            analyzer="toy_vna:ToyVna", analyzer_options=options, maker=MAKER, model=MODEL
        )
        self.deadline = RequestDeadline(self.clock)
        analyzer = make_foreign_analyzer(parameters, self.deadline)
        self.driver = VNADriver(analyzer, parameters, self.deadline, lambda _text: None)
        self.driver.connect_to_vna(ADDRESS)
        self.driver.set_frequency_sweep(SWEEP)
        self.toy = self.instrument.made[-1]

    def hang(self, call: str) -> threading.Thread:
        """Make a request whose call to the class does not return yet."""
        requests = {
            "configure": lambda: self.driver.set_frequency_sweep(SWEEP),
            "check_sweep": lambda: self.driver.set_frequency_sweep(SWEEP),
            "disconnect": self.driver.disconnect_from_vna,
        }
        self.toy.blocks = call
        action = requests.get(call, self.driver.get_trace)

        def ended() -> None:
            with contextlib.suppress(VnaError):
                action()

        request = threading.Thread(target=ended, daemon=True)
        request.start()
        assert self.toy.blocking.wait(LIMIT_S)
        return request

    def overdue_after(self, duration_s: float):
        """Return what is overdue so much later, looking twice."""
        self.clock.pass_s(duration_s)
        self.deadline.overdue()
        return self.deadline.overdue()


@pytest.fixture
def bench():
    made = Bench()
    yield made
    made.toy.freed.set()


@pytest.mark.parametrize(
    "call, limit_s",
    [
        ("confirm", USUAL_S),
        ("calibration", USUAL_S),
        ("disconnect", USUAL_S),
        ("sweep", 10.0 + USUAL_S),
        # As long as a set-up may take.
        ("configure", 40.0 + USUAL_S),
        ("check_sweep", 40.0 + USUAL_S),
    ],
)
def test_a_call_that_does_not_return_is_overdue_after_its_time(bench, call, limit_s):
    request = bench.hang(call)
    assert bench.overdue_after(limit_s - 0.1) is None
    overdue = bench.overdue_after(1.0)
    assert f"toy_vna:ToyVna.{call}" in str(overdue.all_details)
    bench.toy.freed.set()
    request.join(LIMIT_S)
    assert bench.overdue_after(0.0) is None


def test_a_sweep_of_unknown_duration_is_overdue_after_the_time_of_a_request(bench):
    bench.toy.trace_duration_s = None
    bench.driver.check_calibration_status()
    bench.hang("sweep")
    assert bench.overdue_after(40.0 + USUAL_S - 0.1) is None
    assert bench.overdue_after(1.0) is not None


def test_a_call_that_returns_after_a_pause_of_the_process_is_not_overdue(bench):
    request = bench.hang("confirm")
    bench.clock.pass_s(30.0)
    assert bench.deadline.overdue() is None
    bench.toy.freed.set()
    request.join(LIMIT_S)
    assert bench.deadline.overdue() is None


def test_a_shutdown_does_not_wait_for_it(bench, monkeypatch):
    monkeypatch.setattr(vna_driver, "LAST_REQUEST_S", 0.01)
    bench.hang("sweep")
    bench.driver.shut_down()
    with pytest.raises(VnaClosedError):
        bench.deadline.check()


def test_the_process_reports_it_and_ends():
    pytest.importorskip("rospy")
    program = """
import threading
from driver_bench import FakeClock
from gpr20_vna_acquisition.high.vna_node import end_if_overdue
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
clock = FakeClock()
deadline = RequestDeadline(clock)
with deadline.watched("a.B.sweep", 1.0):
    end_if_overdue(deadline)
    clock.pass_s(2.0)
    end_if_overdue(deadline)
    end_if_overdue(deadline)
"""
    ended = subprocess.run(
        [sys.executable, "-c", program],
        cwd=Path(__file__).parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert ended.returncode == 1 and b"a.B.sweep does not return" in ended.stdout
