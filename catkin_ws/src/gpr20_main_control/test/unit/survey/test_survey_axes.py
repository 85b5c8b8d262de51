"""Moves, homings and positions: nothing is measured where the antennas are not."""

import threading

import pytest
from fake_clocks import ManualClock
from fake_robot import Bench, reports

from gpr20_common.message import Fault, Message, Severity
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import MoveOutcome
from gpr20_survey.plan.survey_state import SurveyState as State

STOPPED_BY_OTHERS = Fault("axis.stopped", Message("Nothing to do"), Severity.NOTE)


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
    assert reports(status.message, faults.MOVE_FAILED, "y", 5.0)
    assert bench.y.fail_move in str(status.message)
    assert bench.analyzer.sweeps == 0
    bench.y.fail_move = ""
    bench.resume_to_the_end()


def test_a_move_that_ends_elsewhere_is_never_measured(bench):
    bench.x.stay = True
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.AXIS_OFF_TARGET, "x", 0.0, 10.0)
    assert bench.storage.samples == []


def test_a_lost_result_is_settled_by_the_axis_own_coordinate(bench):
    bench.x.lose_result = True
    bench.start()
    bench.complete()


def test_a_move_that_never_ends_pauses_the_survey_after_its_time_limit(bench):
    bench.x.blocked.clear()
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.MOVE_TOO_LONG, "x", 10.0)
    assert bench.x.stops > 0


def test_a_silent_axis_pauses_the_survey_and_it_goes_on_when_it_speaks_again(bench):
    bench.analyzer.on_sweep = lambda: setattr(bench.z, "silent", bench.analyzer.sweeps == 5)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.NODE_LOST, "z")
    bench.analyzer.on_sweep = lambda: None
    bench.z.silent = False
    bench.resume_to_the_end()


def test_an_axis_that_falls_silent_in_a_move_may_still_move(bench):
    bench.x.blocked.clear()
    bench.x.begin_move = lambda _target: setattr(bench.x, "silent", True)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.AXIS_SILENT, "x")
    assert status.message.may_move


def test_an_axis_that_another_client_stops_in_a_move_must_be_clear_before_the_next(bench):
    stopped = MoveOutcome(False, Message("the move was stopped").with_fault(STOPPED_BY_OTHERS))
    bench.y.begin_move = lambda _target: setattr(bench.y, "_outcome", stopped)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.MOVE_FAILED, "y", 5.0)


def test_an_axis_that_another_client_stops_in_its_homing_must_be_clear_before_the_next(bench):
    def stopped(_limit_s):
        raise DeviceError(Message("homing was stopped").with_fault(STOPPED_BY_OTHERS))

    bench.x.home = stopped
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.HOMING_FAILED, "x")


def test_an_axis_that_lost_its_zero_is_homed_before_the_survey_goes_on(bench):
    def lose_zero():
        if bench.analyzer.sweeps == 5:
            bench.x.homed = False
            bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = lose_zero
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.AXIS_NOT_HOMED, "x")
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
    assert reports(status.message, faults.MOVED_BY_OTHERS, 0)
    assert bench.storage.samples == []


def test_an_axis_whose_node_is_still_starting_is_waited_for(bench):
    bench.z.silent_readings = 3
    bench.start()
    bench.wait_for(State.FINISHED)


def test_an_axis_that_never_speaks_fails_the_survey_before_anything_moves(bench):
    bench.z.silent = True
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert reports(final.message, faults.NODE_LOST, "z")
    assert bench.x.moves == []


@pytest.mark.parametrize("offset", [0.01, -0.04])
def test_an_axis_that_rests_a_step_beside_its_target_is_never_measured(bench, offset):
    bench.x.offset = offset
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert status.message.fault_code in (faults.AXIS_OFF_TARGET.code, faults.MOVED_BY_OTHERS.code)
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
    assert faults.HOMING_FAILED in status.message.faults
    assert bench.x.fail_homing in str(status.message)
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
    assert reports(status.message, faults.MOVED_BY_OTHERS, -5.4)
    assert all(sample.z_coord_deg in (0.0, 90.0) for sample in bench.storage.samples)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
