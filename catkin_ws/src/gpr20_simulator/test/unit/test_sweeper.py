"""Sweeps while time passes, and the memory of the display."""

from __future__ import annotations

import random
import threading
from unittest import mock

import numpy as np
import pytest
from run_seed import draws
from vna_bench import POINTS, SWEEP_S, Bench
from wait_kit import wait_until

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.sweeper import (
    Sweeper,
    SweepPace,
    SweepPart,
    SweepPlan,
    TraceMemory,
)
from gpr20_simulator.mid.world.medium import (
    AntennaPosition,
    PositionProbe,
    probed_position_mm,
    probed_sweep,
)

PART_S = SWEEP_S / 10.0


@pytest.fixture
def bench():
    return Bench(pace=SweepPace(slice_s=PART_S))


def test_a_trigger_gives_one_sweep_and_holds(bench):
    number = bench.sweeper.sweep_number
    bench.send(":INIT:IMM")
    bench.pass_s(SWEEP_S - 1e-6)
    assert bench.ask(":STAT:OPER?") == "0"
    bench.pass_s(2e-6)
    assert bench.ask(":STAT:OPER?") == "256"
    bench.pass_s(10 * SWEEP_S)
    assert bench.sweeps() == [number + 1] * POINTS and not bench.sweeper.is_running


def test_a_sweep_during_a_move_sees_the_move(bench):
    bench.send(":INIT:IMM")
    for part in range(11):
        bench.move(float(part))
        bench.pass_s(PART_S)
    places_mm = [probed_position_mm(value)[0] for value in bench.values()]
    assert places_mm == sorted(places_mm) and len(set(places_mm)) >= 10


def test_data_in_mid_sweep_are_a_mixture_until_a_trigger_begins_anew(bench):
    number = bench.sweeper.sweep_number
    bench.send(":INIT:IMM")
    bench.pass_s(SWEEP_S / 2)
    sweeps = bench.sweeps()
    assert sweeps == sorted(sweeps, reverse=True) and set(sweeps) == {number, number + 1}
    bench.sweep()
    assert bench.sweeps() == [number + 2] * POINTS


def test_continuous_sweeps_follow_each_other_until_held(bench):
    completed = bench.sweeper.sweeps_completed
    bench.send(":INIT:CONT ON")
    bench.pass_s(1.0)
    bench.send(":INIT:CONT OFF")
    # At most one in 0.1 s.
    assert 8 <= bench.sweeper.sweeps_completed - completed <= 10
    held = bench.sweeper.sweeps_completed
    bench.pass_s(1.0)
    assert bench.sweeper.sweeps_completed == held and not bench.sweeper.is_running


def test_its_own_thread_sweeps_while_nobody_asks():
    plan = SweepPlan(1e9, 2e9, 10, 1e-3)
    here = AntennaPosition(0.0, 0.0, 0.0)
    sweeper = Sweeper(PositionProbe(), lambda: here, Clock(), plan, SweepPace())
    sweeper.start()
    sweeper.trigger()
    wait_until(lambda: sweeper.is_complete)
    assert {probed_sweep(value) for value in sweeper.snapshot()[1]} == {1}
    sweeper.stop()
    assert "sweeper" not in {one.name for one in threading.enumerate()}


# The memory: data that are computed only when somebody looks at them are those computed at once.

FEW = 24


def memory(medium=None):
    return TraceMemory(medium or PositionProbe(), np.linspace(1e9, 2e9, FEW))


def parts_of(sweep_number, cuts, x_mm=0.0):
    edges = [0, *cuts, FEW]
    here = AntennaPosition(x_mm, 0.0, 0.0)
    return [SweepPart(sweep_number, a, b, here, 1.0) for a, b in zip(edges, edges[1:])]


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
    medium = PositionProbe()
    medium.s21 = mock.Mock(wraps=medium.s21)
    one = memory(medium)
    for number in range(1, 101):
        for part in parts_of(number, [7, 15]):
            one.store(part)
    medium.s21.assert_not_called()
    assert set(map(probed_sweep, one.shown(0.0))) == {100}
    # The last sweep, in one piece, and the one before it.
    assert medium.s21.call_count == 2
    # Data of as many points stay when the frequencies change.
    one.set_frequencies(np.linspace(1e9, 3e9, FEW))
    assert set(map(probed_sweep, one.shown(0.0))) == {100}
    one.set_frequencies(np.linspace(1e9, 3e9, 5))
    assert list(one.shown(0.0)) == [0] * 5
