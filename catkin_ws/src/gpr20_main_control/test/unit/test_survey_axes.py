"""Moves, homings and positions: nothing is measured where the antennas are not."""

import threading

import pytest
from fake_clocks import ManualClock
from fake_robot import Bench

from gpr20_survey.plan.survey_state import SurveyState as State


def test_each_axis_gets_its_own_targets(bench):
    bench.start()
    bench.wait_for(State.FINISHED)
    assert set(bench.x.moves) == {10.0, 20.0, 30.0}
    assert set(bench.y.moves) == {5.0, 15.0, 25.0, 35.0}
    assert set(bench.z.moves) == {0.0, 90.0}


def test_no_move_of_zero_length_is_sent(bench):
    bench.start()
    bench.wait_for(State.FINISHED)
    for axis in bench.axes:
        assert all(a != b for a, b in zip([0.0, *axis.moves], axis.moves))


def test_homed_axes_are_not_homed_again(bench):
    bench.x.homed = bench.y.homed = bench.z.homed = True
    bench.start()
    bench.wait_for(State.FINISHED)
    assert [axis.homings for axis in bench.axes] == [0, 0, 0]


def test_what_an_axis_said_before_its_node_was_restarted_does_not_count(bench):
    bench.x.readings_from_before = 4
    bench.start()
    bench.complete()
    assert bench.x.homings == 1


def test_a_refused_move_is_never_measured_and_pauses_the_survey(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "y axis did not reach 5 mm: the endstop was pressed" in str(status.message)
    assert bench.analyzer.sweeps == 0
    bench.y.fail_move = ""
    bench.resume_to_the_end()


def test_a_move_that_ends_elsewhere_is_never_measured(bench):
    bench.x.stay = True
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "the x axis is at 0 mm instead of 10 mm" in str(status.message)
    assert bench.storage.samples == []


def test_a_lost_result_is_settled_by_the_axis_own_coordinate(bench):
    bench.x.lose_result = True
    bench.start()
    bench.complete()


def test_a_move_that_never_ends_pauses_the_survey_after_its_time_limit(bench):
    bench.x.blocked.clear()
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "did not end its move to 10 mm within" in str(status.message)
    assert bench.x.stops > 0


def test_a_silent_axis_pauses_the_survey_and_it_goes_on_when_it_speaks_again(bench):
    bench.analyzer.on_sweep = lambda: setattr(bench.z, "silent", bench.analyzer.sweeps == 5)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "z axis has not reported its position" in str(status.message)
    bench.analyzer.on_sweep = lambda: None
    bench.z.silent = False
    bench.resume_to_the_end()


def test_an_axis_that_lost_its_zero_is_homed_before_the_survey_goes_on(bench):
    def lose_zero():
        if bench.analyzer.sweeps == 5:
            bench.x.homed = False
            bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = lose_zero
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "x axis is not homed" in str(status.message)
    assert len(bench.storage.samples) <= 5
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert bench.x.homings == 2
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_trace_is_not_stored_if_the_axes_moved_during_its_sweep(bench):
    def push():
        bench.x.coordinate += 0.01
        bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = push
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "moved during the sweep at point 0" in str(status.message)
    assert bench.storage.samples == []


def test_an_axis_whose_node_is_still_starting_is_waited_for(bench):
    bench.z.silent_readings = 3
    bench.start()
    bench.wait_for(State.FINISHED)


def test_an_axis_that_never_speaks_fails_the_survey_before_anything_moves(bench):
    bench.z.silent = True
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "z axis has not reported its position" in str(final.message)
    assert bench.x.moves == []


@pytest.mark.parametrize("offset", [0.01, -0.01, 0.04])
def test_an_axis_that_rests_a_step_beside_its_target_is_never_measured(bench, offset):
    bench.x.offset = offset
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "instead of 10 mm" in str(status.message)
    assert bench.storage.samples == []


def test_every_sweep_comes_after_the_antennas_have_settled():
    clock = ManualClock()
    bench = Bench(clock=clock, settle_s=0.7)
    settled = []
    bench.analyzer.on_sweep = lambda: settled.append(clock.waits_s.count(0.7))
    bench.start()
    bench.wait_for(State.FINISHED)
    assert settled == list(range(1, 25))


def test_every_sweep_is_prepared_while_the_antennas_settle(monkeypatch):
    bench = Bench(clock=ManualClock(), settle_s=0.7)
    prepared = threading.Semaphore(0)
    monkeypatch.setattr(bench.analyzer, "prepare", prepared.release)
    bench.start()
    bench.wait_for(State.FINISHED)
    assert all(prepared.acquire(timeout=5.0) for _ in bench.storage.samples)
    assert not prepared.acquire(blocking=False)


def test_every_axis_is_homed_even_if_one_fails_and_the_failure_is_told(bench):
    bench.x.fail_homing = "it is stuck open"
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "homing the x axis failed: it is stuck open" in str(status.message)
    assert [axis.homings for axis in bench.axes] == [1, 1, 1]


def test_an_axis_that_somebody_else_moved_during_the_settling_is_never_measured():
    clock = ManualClock()
    bench = Bench(clock=clock, settle_s=0.7)

    usual = clock.wait_s

    def meddle(event, timeout_s):
        if timeout_s == 0.7 and len(bench.storage.samples) >= 2:
            bench.z.coordinate = -5.4
        return usual(event, timeout_s)

    clock.wait_s = meddle
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "z -5.4 deg" in str(status.message)
    assert all(sample.z_coord_deg in (0.0, 90.0) for sample in bench.storage.samples)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
