"""The computer's clock is set during a survey, or between two sessions of it."""

import random

import pytest
from fake_robot import ManualClock
from run_seed import draws

from gpr20_main_control.mid.survey.clock_steps import LARGEST_CORRECTION_S, ClockSteps
from gpr20_survey.faults import CLOCK_WRONG

DRAWS = draws(50)


class Steps:
    def __init__(self, last=None):
        self.clock = ManualClock()
        self.said = []
        self.steps = ClockSteps(self.clock, last, self._note)

    def _note(self, message):
        shown = message.values["step_s"]
        self.said.append((message.fault_code, pytest.approx(shown, abs=0.01)))

    def next_trace(self):
        self.clock.time_s += 1.0
        return self.steps.check_trace(self.clock.time_of_day_us())


def test_a_clock_that_is_set_is_said_once_with_the_step():
    bench = Steps()
    assert bench.next_trace() is None
    bench.clock.set_s -= 3600.0
    assert bench.next_trace() is not None
    assert bench.next_trace() is None
    bench.clock.set_s += 86400.0
    bench.steps.check()
    assert bench.next_trace() is None
    assert bench.said == [
        (CLOCK_WRONG.as_warning().code, 3600.0),
        (CLOCK_WRONG.as_warning().code, 86400.0),
    ]


def test_a_small_step_is_said_if_it_orders_two_traces_wrongly():
    bench = Steps()
    bench.next_trace()
    bench.clock.set_s -= 0.5
    assert bench.next_trace() is None
    bench.clock.set_s -= 1.5
    bench.next_trace()
    assert bench.said == [(CLOCK_WRONG.as_warning().code, 0.5)]


def test_nothing_is_said_of_a_clock_that_is_corrected_by_little_in_any_order():
    for seed in range(DRAWS):
        draw = random.Random(seed)
        bench = Steps()
        for _trace in range(20):
            bench.clock.time_s += draw.uniform(2.0, 100.0)
            bench.clock.set_s += draw.uniform(-1.0, 1.0) * LARGEST_CORRECTION_S
            assert bench.next_trace() is None, seed
