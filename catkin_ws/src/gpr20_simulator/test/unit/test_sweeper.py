"""Sweeps against a clock that the test moves by hand, and the memory of the display."""

from __future__ import annotations

import random

import numpy as np
import pytest
from run_seed import draws
from vna_bench import Carriage, CountingProbe, HandClock, wait_until

from gpr20_simulator.mid.analyzer.sweeper import Sweeper, SweepPace, SweepPlan
from gpr20_simulator.mid.analyzer.trace_memory import SweepPart, TraceMemory
from gpr20_simulator.mid.world.medium import (
    AntennaPosition,
    PositionProbe,
    probed_position_mm,
    probed_sweep,
)

POINTS = 100
POINT_S = 0.01
SWEEP_S = POINTS * POINT_S
PLAN = SweepPlan(1e9, 2e9, POINTS, POINT_S)
# Ten points share one look at the position.
PACE = SweepPace(slice_s=0.1001, series_s=0.1001)


class SweeperRig:
    def __init__(self, plan=PLAN, pace=PACE, medium=None):
        self.clock = HandClock()
        self.carriage = Carriage()
        self.sweeper = Sweeper(
            medium or PositionProbe(), self.carriage.position, self.clock, plan, pace
        )
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

    def wait_for_completed(self, count):
        wait_until(lambda: self.sweeper.sweeps_completed == count, f"sweep {count}")


@pytest.fixture
def make():
    made = []

    def make_rig(*arguments, **options):
        made.append(SweeperRig(*arguments, **options))
        return made[-1]

    yield make_rig
    for one in made:
        one.sweeper.stop()


@pytest.fixture
def rig(make):
    return make()


def test_trigger_gives_one_sweep_and_holds(rig):
    rig.clock.advance(10 * SWEEP_S)
    assert not rig.sweeper.is_running and not rig.sweeper.is_complete
    assert rig.sweeper.sweep_number == 0
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S - 1e-6)
    rig.wait_for_points(1, 90)
    assert not rig.sweeper.is_complete
    rig.clock.advance(2e-6)
    wait_until(lambda: rig.sweeper.is_complete, "end of the sweep")
    rig.clock.advance(10 * SWEEP_S)
    assert not rig.sweeper.is_running
    assert rig.sweeps() == [1] * POINTS
    assert rig.sweeper.sweeps_completed == 1


def test_sweep_during_a_move_sees_the_move(rig):
    rig.sweeper.trigger()
    for part in range(10):
        rig.carriage.move(float(part))
        rig.clock.advance(SWEEP_S / 10 + 1e-9)
        rig.wait_for_points(1, 10 * (part + 1))
    assert rig.xs_mm() == [part for part in range(10) for _ in range(10)]


def test_data_in_mid_sweep_are_a_mixture_until_a_trigger_begins_anew(rig):
    rig.sweeper.trigger()
    rig.finish()
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S / 2 + 1e-6)
    rig.wait_for_points(2, 50)
    assert rig.sweeps() == [2] * 50 + [1] * 50
    rig.sweeper.trigger()
    rig.finish()
    assert rig.sweeps() == [3] * POINTS


def test_continuous_sweeps_follow_each_other_until_held(rig):
    rig.sweeper.set_continuous(True)
    for number in range(1, 4):
        rig.clock.advance(SWEEP_S)
        rig.wait_for_completed(number)
    rig.sweeper.set_continuous(False)
    rig.clock.advance(5 * SWEEP_S)
    assert rig.sweeper.sweeps_completed == 3
    assert not rig.sweeper.is_running
    # One sweep of a trigger, after which it stays held.
    rig.sweeper.trigger()
    rig.clock.advance(SWEEP_S)
    rig.wait_for_completed(4)
    assert not rig.sweeper.is_running


def test_averaging_takes_the_mean_of_the_sweeps(rig):
    def sweep(x_mm):
        rig.carriage.move(x_mm)
        rig.sweeper.trigger()
        rig.finish()

    rig.sweeper.configure(SweepPlan(1e9, 2e9, POINTS, POINT_S, averages=2))
    sweep(10.0)
    sweep(20.0)
    assert rig.xs_mm() == [15] * POINTS
    assert rig.sweeper.averaged == 2
    rig.sweeper.restart_average()
    sweep(20.0)
    assert rig.xs_mm() == [20] * POINTS
    rig.sweeper.configure(SweepPlan(1e9, 3e9, POINTS, POINT_S, averages=2))
    sweep(30.0)
    assert rig.xs_mm() == [30] * POINTS


# The memory: data that are computed only when somebody looks at them are those computed at once.

FEW = 24


def memory(medium=None):
    return TraceMemory(medium or PositionProbe(), np.linspace(1e9, 2e9, FEW))


def parts_of(sweep_number, cuts, x_mm=0.0):
    edges = [0, *cuts, FEW]
    here = AntennaPosition(x_mm, 0.0, 0.0)
    return [SweepPart(sweep_number, a, b, here, 1.0, 1.0) for a, b in zip(edges, edges[1:])]


def test_later_is_as_good_as_at_once():
    for seed in range(draws(20)):
        draw = random.Random(seed)
        at_once, later = memory(), memory()
        for number in range(1, draw.randrange(2, 9)):
            cuts = sorted(draw.sample(range(1, FEW), draw.randrange(4)))
            for part in parts_of(number, cuts, float(draw.randrange(3))):
                at_once.store(part)
                at_once.compute()
                later.store(part)
                if draw.random() < 0.1:
                    assert np.array_equal(later.shown(0.0), at_once.shown(0.0)), seed
        assert np.array_equal(later.shown(0.0), at_once.shown(0.0)), seed


def test_sweeps_that_nobody_sees_cost_nothing():
    medium = CountingProbe()
    one = memory(medium)
    for number in range(1, 101):
        for part in parts_of(number, [7, 15]):
            one.store(part)
    assert medium.calls == 0
    assert set(map(probed_sweep, one.shown(0.0))) == {100}
    # The last sweep, in one piece, and the one before it.
    assert medium.calls == 2
    # Data of as many points stay when the frequencies change.
    one.set_frequencies(np.linspace(1e9, 3e9, FEW))
    assert set(map(probed_sweep, one.shown(0.0))) == {100}
    one.set_frequencies(np.linspace(1e9, 3e9, 5))
    assert list(one.shown(0.0)) == [0] * 5
