"""Sweeps against a clock that the test moves by hand."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest
from rpc_wire import wait_until
from vna_bench import Carriage, CountingProbe, HandClock

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.sweep_plan import SweepFaults, SweepPace, SweepPlan
from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.world.medium import PositionProbe, probed_position_mm, probed_sweep

POINTS = 100
POINT_S = 0.01
SWEEP_S = POINTS * POINT_S
PLAN = SweepPlan(1e9, 2e9, POINTS, POINT_S)
# Ten points share one look at the position.
PACE = SweepPace(slice_s=0.1001, shortest_period_s=0.5)


class Rig:
    def __init__(self, clock, plan=PLAN, pace=PACE):
        self.clock = clock
        self.carriage = Carriage()
        self.sweeper = Sweeper(PositionProbe(), self.carriage.position, clock, plan, pace)
        self.sweeper.start()

    def sweeps(self):
        """Return the numbers of the sweeps that the points are from."""
        return [probed_sweep(value) for value in self.sweeper.snapshot()[1]]

    def xs_mm(self):
        return [probed_position_mm(value)[0] for value in self.sweeper.snapshot()[1]]

    def finish(self):
        """Let the time of a sweep pass, and wait for its end."""
        self.clock.advance(SWEEP_S)
        wait_until(lambda: self.sweeper.is_complete, "end of the sweep")

    def wait_for_points(self, number, count):
        wait_until(lambda: self.sweeps().count(number) == count, f"{count} points of {number}")


@pytest.fixture
def rig():
    one = Rig(HandClock())
    yield one
    one.sweeper.stop()


def test_nothing_is_swept_before_it_is_asked_for(rig):
    rig.clock.advance(10 * SWEEP_S)
    assert not rig.sweeper.is_running
    assert not rig.sweeper.is_complete
    assert rig.sweeper.sweep_number == 0


def test_trigger_gives_one_sweep_and_holds(rig):
    rig.sweeper.trigger()
    assert not rig.sweeper.is_complete
    rig.finish()
    rig.clock.advance(10 * SWEEP_S)
    assert not rig.sweeper.is_running
    assert rig.sweeps() == [1] * POINTS
    assert rig.sweeper.sweeps_completed == 1


def test_sweep_takes_its_time(rig):
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S - 1e-6)
    rig.wait_for_points(1, 90)
    assert not rig.sweeper.is_complete
    rig.clock.advance(2e-6)
    wait_until(lambda: rig.sweeper.is_complete, "end of the sweep")


def test_sweep_during_a_move_sees_the_move(rig):
    rig.sweeper.trigger()
    for part in range(10):
        rig.carriage.move(float(part))
        rig.clock.advance(SWEEP_S / 10 + 1e-9)
        rig.wait_for_points(1, 10 * (part + 1))
    assert rig.xs_mm() == [part for part in range(10) for _ in range(10)]


def test_data_in_mid_sweep_are_a_mixture(rig):
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S)
    rig.wait_for_points(1, POINTS)
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S / 2 + 1e-6)
    rig.wait_for_points(2, 50)
    assert rig.sweeps() == [2] * 50 + [1] * 50


def test_trigger_in_mid_sweep_begins_anew_with_new_points_only(rig):
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S * 0.7)
    rig.wait_for_points(1, 70)
    rig.sweeper.trigger()
    rig.finish()
    assert rig.sweeps() == [2] * POINTS


class SlowMedium:
    """Lets the test hold up the measurement of the first slice."""

    def __init__(self):
        self.entered = threading.Event()
        self.may_go_on = threading.Event()

    def s21(self, frequency_hz, position, sweep_number, noise_gain=1.0):
        self.entered.set()
        self.may_go_on.wait(5.0)
        return PositionProbe().s21(frequency_hz, position, sweep_number)


def test_points_still_being_measured_at_a_trigger_are_thrown_away():
    clock, medium = HandClock(), SlowMedium()
    sweeper = Sweeper(medium, Carriage().position, clock, PLAN, PACE)
    sweeper.start()
    sweeper.trigger()
    clock.advance(0.11)
    assert medium.entered.wait(5.0)
    sweeper.trigger()
    medium.may_go_on.set()
    clock.advance(0.11)
    wait_until(lambda: sweeper.snapshot()[1][0] != 0, "first slice of the new sweep")
    assert [probed_sweep(value) for value in sweeper.snapshot()[1][:10]] == [2] * 10
    assert list(sweeper.snapshot()[1][10:]) == [0] * 90
    sweeper.stop()


def test_continuous_sweeps_follow_each_other_until_held(rig):
    rig.sweeper.set_continuous(True)
    for number in range(1, 5):
        rig.clock.advance(SWEEP_S)
        wait_until(lambda n=number: rig.sweeper.sweeps_completed == n, f"sweep {number}")
    rig.sweeper.hold(True)
    rig.clock.advance(5 * SWEEP_S)
    assert rig.sweeper.sweeps_completed == 4
    assert not rig.sweeper.is_running
    assert rig.sweeper.is_continuous


def test_held_series_goes_on_where_it_paused(rig):
    rig.sweeper.set_continuous(True)
    rig.clock.advance(SWEEP_S / 2 + 1e-6)
    rig.wait_for_points(1, 50)
    rig.sweeper.hold(True)
    rig.clock.advance(10 * SWEEP_S)
    rig.sweeper.hold(False)
    assert rig.sweeps().count(1) == 50
    rig.clock.advance(SWEEP_S / 2)
    wait_until(lambda: rig.sweeper.sweeps_completed == 1, "end of the paused sweep")
    assert rig.sweeps() == [1] * POINTS


def test_trigger_in_a_running_series_leaves_it_running(rig):
    rig.sweeper.set_continuous(True)
    rig.sweeper.trigger()
    rig.finish()
    assert rig.sweeper.is_running


def test_trigger_in_a_held_series_is_one_sweep(rig):
    rig.sweeper.set_continuous(True)
    rig.sweeper.hold(True)
    rig.sweeper.trigger()
    rig.finish()
    assert not rig.sweeper.is_running


def test_stale_trigger_is_complete_at_once_and_keeps_the_old_data(rig):
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S)
    rig.wait_for_points(1, POINTS)
    rig.sweeper.trigger(SweepFaults(stale=True))
    assert rig.sweeper.is_complete
    rig.clock.advance(SWEEP_S)
    wait_until(lambda: rig.sweeper.sweeps_completed == 2, "end of the sweep")
    assert rig.sweeps() == [1] * POINTS


def test_new_plan_begins_the_sweep_anew_and_clears_the_bit(rig):
    rig.sweeper.set_continuous(True)
    rig.finish()
    rig.sweeper.configure(SweepPlan(1e9, 3e9, 7, POINT_S))
    assert not rig.sweeper.is_complete
    frequency_hz, values = rig.sweeper.snapshot()
    assert list(frequency_hz) == list(np.linspace(1e9, 3e9, 7))
    assert list(values) == [0] * 7


def test_averaging_takes_the_mean_of_the_sweeps(rig):
    rig.sweeper.configure(SweepPlan(1e9, 2e9, POINTS, POINT_S, averages=2))
    for x_mm in (10.0, 20.0):
        rig.carriage.move(x_mm)
        rig.sweeper.trigger()
        rig.finish()
    assert rig.xs_mm() == [15] * POINTS
    assert rig.sweeper.averaged == 2
    rig.sweeper.restart_average()
    sweep_and_expect(rig, 20)
    rig.carriage.move(30.0)
    rig.sweeper.configure(SweepPlan(1e9, 3e9, POINTS, POINT_S, averages=2))
    sweep_and_expect(rig, 30)


def sweep_and_expect(rig, x_mm):
    rig.sweeper.trigger()
    rig.finish()
    assert rig.xs_mm() == [x_mm] * POINTS


def used_s(rig):
    """Return the processor time of the sweeper's own thread."""
    return time.clock_gettime(time.pthread_getcpuclockid(rig.sweeper._thread.ident))


def test_sweep_that_takes_no_time_does_not_spin():
    rig = Rig(Clock(), SweepPlan(1e9, 2e9, 10, 0.0), SweepPace(0.0015, 0.05))
    # Before the first sweep, which may begin and end at once.
    started_s = time.monotonic()
    rig.sweeper.set_continuous(True)
    wait_until(lambda: rig.sweeper.sweeps_completed >= 4, "four sweeps")
    duration_s = time.monotonic() - started_s
    assert duration_s >= 3 * 0.05
    assert used_s(rig) < 0.7 * duration_s
    rig.sweeper.stop()


def test_held_sweeper_uses_no_processor_time():
    rig = Rig(Clock())
    time.sleep(0.1)
    assert used_s(rig) < 0.07
    rig.sweeper.stop()


def test_series_that_nobody_reads_is_not_computed_and_hardly_watched():
    clock, carriage, medium = HandClock(), Carriage(), CountingProbe()
    # 70 ms a sweep, as at power-on; one look is enough for it.
    plan, pace = SweepPlan(1e9, 2e9, 201, 350e-6), SweepPace(attention_s=0.2)
    sweeper = Sweeper(medium, carriage.position, clock, plan, pace)
    sweeper.start()
    sweeper.set_continuous(True)

    def sweep():
        before = sweeper.sweeps_completed
        clock.advance(pace.rest_s)
        wait_until(lambda: sweeper.sweeps_completed > before, "next sweep")

    # The first look counts as a move.
    for _ in range(5):
        sweep()
    looks, completed = carriage.looks, sweeper.sweeps_completed
    for _ in range(20):
        sweep()
    assert 20 <= sweeper.sweeps_completed - completed <= 22
    assert carriage.looks - looks <= 22
    assert medium.calls == 0
    newest = sweeper.sweep_number
    read = {probed_sweep(value) for value in sweeper.snapshot()[1]}
    assert read <= {newest - 1, newest, newest + 1}
    sweeper.stop()


def test_series_sees_a_move_that_begins_while_nobody_reads(rig):
    rig.sweeper.set_continuous(True)
    rig.clock.advance(3 * SWEEP_S)
    wait_until(lambda: rig.sweeper.sweeps_completed >= 1, "first sweep")
    for part in range(1, 40):
        rig.carriage.move(float(part))
        looks = rig.carriage.looks
        rig.clock.advance(SWEEP_S / 10 + 1e-9)
        wait_until(lambda n=looks: rig.carriage.looks > n, "look at the position")
    # Many places in one sweep, though it is computed only now.
    assert len(set(rig.xs_mm())) >= 8
