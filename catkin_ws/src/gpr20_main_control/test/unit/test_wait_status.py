"""What the status says while an answer is waited for."""

import re
import threading

import pytest
from fake_robot import LIMIT_S, Bench

from gpr20_survey.plan.survey_state import SurveyState as State

UNTIL = r", until \d\d:\d\d:\d\d at the latest$"


def shown(bench):
    return str(bench.board.status.full_message)


@pytest.mark.parametrize(
    "part, call, index, text",
    [
        ("analyzer", "sweep", 3, "the VNA: sweep at point 3"),
        ("analyzer", "confirm", 3, "the VNA: settings after the sweep at point 3"),
        ("analyzer", "connect", 0, "the VNA: connection"),
        ("height", "height_m", 4, "the height sensor: height at point 3"),
    ],
)
def test_a_call_that_takes_long_is_shown_until_it_ends(bench, part, call, index, text):
    """One real second is a thousand for the survey."""
    hang, calls = threading.Event(), []
    device = getattr(bench, part)
    usual = getattr(device, call)

    def hang_once(*arguments):
        calls.append(arguments)
        if len(calls) == index + 1:
            hang.wait(LIMIT_S)
        return usual(*arguments)

    setattr(device, call, hang_once)
    bench.start()
    bench.wait_until(lambda: re.fullmatch(f"Waiting for {text}{UNTIL}", shown(bench)))
    state = bench.board.status.state
    hang.set()
    bench.wait_until(lambda: "Waiting" not in shown(bench))
    bench.complete()
    assert state is (State.CHECKING if index == 0 else State.SURVEYING)


def test_a_storage_that_takes_long_is_shown(bench):
    bench.storage.free.clear()
    bench.start()
    text = "the storage: traces up to point 4"
    bench.wait_until(lambda: re.fullmatch(f"Waiting for {text}{UNTIL}", shown(bench)))
    bench.storage.free.set()
    bench.complete()


def test_a_slow_sweep_is_not_late():
    bench = Bench()
    bench.analyzer.sweep_duration_s = 35.0
    bench.analyzer.on_sweep = lambda: bench.clock.wait_s(threading.Event(), 30.0)
    bench.start()
    bench.complete()
    assert not any(status.waiting for status in bench.history)


def test_a_fault_replaces_what_was_waited_for(bench):
    hang = threading.Event()

    def fail_late():
        if bench.analyzer.sweeps == 2:
            hang.wait(LIMIT_S)
            bench.analyzer.failures = 1

    bench.analyzer.on_sweep = fail_late
    bench.start()
    bench.wait_until(lambda: "sweep at point 2" in shown(bench))
    hang.set()
    bench.wait_for(State.PAUSED)
    assert shown(bench).startswith("Paused: the VNA did not answer")
