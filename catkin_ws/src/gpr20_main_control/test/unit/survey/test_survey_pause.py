"""Pauses, and how a survey continues after them."""

import pytest
from fake_clocks import ManualClock
from fake_robot import Bench
from fault_kit import raises_fault

from gpr20_main_control import faults
from gpr20_main_control.errors import RequestRefusedError
from gpr20_survey.plan.survey_state import SurveyState as State


def test_resume_names_the_survey_that_is_paused(bench):
    bench.y.fail_move = "the endstop was pressed"
    survey_id = bench.start()
    bench.wait_for(State.PAUSED)
    with raises_fault(faults.OTHER_PAUSED, survey_id, error=RequestRefusedError):
        bench.control.resume("another")
    bench.y.fail_move = ""
    bench.control.resume(survey_id)
    bench.wait_for(State.FINISHED)


def test_a_pause_does_not_count_for_the_remaining_time_and_loses_none():
    clock = ManualClock()
    bench = Bench(clock=clock)

    def pass_time():
        clock.time_s += 10.0
        if bench.analyzer.sweeps == 5:
            bench.y.fail_move = "the endstop was pressed"

    bench.analyzer.on_sweep = pass_time
    bench.start()
    bench.wait_for(State.PAUSED)
    clock.time_s += 1.0e6
    bench.y.fail_move = ""
    bench.analyzer.on_sweep = lambda: None
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert max(status.remaining_s for status in bench.history) < 1000.0
    # Nor is the pace before the pause forgotten.
    assert all(status.remaining_s > 0.0 for status in bench.history if status.visited_points == 6)


def paused_on_request(bench, after):
    """Pause a survey once so many sweeps have begun; return its id."""

    def ask():
        if bench.analyzer.sweeps == after - 1:
            bench.control.pause()

    bench.analyzer.on_sweep = ask
    survey_id = bench.start()
    bench.wait_for(State.PAUSED)
    bench.analyzer.on_sweep = lambda: None
    return survey_id


@pytest.mark.parametrize("after", [1, 23])
def test_a_pause_finishes_the_present_sample_and_holds(bench, after):
    paused_on_request(bench, after)
    assert bench.analyzer.sweeps == after
    bench.wait_for_visited(after)
    assert "PAUSING" in bench.states
    bench.resume_to_the_end()


def test_a_pause_at_the_last_sample_ends_as_finished(bench):
    bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 23 and bench.control.pause()
    bench.start()
    bench.complete()
