"""Data that are computed only when somebody looks at them are those computed at once."""

from __future__ import annotations

import os
import random

import numpy as np
import pytest
from case_kit import each_case
from vna_bench import CountingProbe

from gpr20_simulator.mid.analyzer.trace_memory import MOST_WAITING_SWEEPS, SweepPart, TraceMemory
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe

DRAWS = int(os.environ.get("GPR20_TRACE_MEMORY_DRAWS", "40"))
POINTS = 24


def memory(medium=None):
    return TraceMemory(medium or PositionProbe(), np.linspace(1e9, 2e9, POINTS))


def parts_of(sweep_number, cuts, x_mm=0.0):
    edges = [0, *cuts, POINTS]
    here = AntennaPosition(x_mm, 0.0, 0.0)
    return [SweepPart(sweep_number, a, b, here, 1.0) for a, b in zip(edges, edges[1:])]


def share_of(sweep_number, averages):
    return 1.0 / min(sweep_number, averages)


@each_case("averages", [1, 3])
@each_case("seed", range(DRAWS))
def test_later_is_as_good_as_at_once(seed, averages):
    draw = random.Random(seed)
    at_once, later = memory(), memory()
    for number in range(1, draw.randrange(2, MOST_WAITING_SWEEPS)):
        cuts = sorted(draw.sample(range(1, POINTS), draw.randrange(4)))
        for part in parts_of(number, cuts, float(draw.randrange(3))):
            share = share_of(number, averages)
            at_once.store(part, at_once.measured(part), share)
            later.store(part, None, share)
            if draw.random() < 0.1:
                assert np.allclose(later.data(), at_once.data(), rtol=1e-6)
    assert np.allclose(later.data(), at_once.data(), rtol=1e-6)


def test_sweeps_that_nobody_sees_cost_nothing():
    medium = CountingProbe()
    one = memory(medium)
    for number in range(1, 1001):
        for part in parts_of(number, [7, 15]):
            one.store(part, None, 1.0)
    assert medium.calls == 0
    assert set(one.data().real.astype(int)) == {1000}
    # The last sweep, in one piece, and the one before it.
    assert medium.calls == 2


def test_average_at_rest_is_that_of_the_place_where_the_antennas_are():
    medium = CountingProbe()
    one = memory(medium)
    for part in parts_of(1, [], x_mm=500.0):
        one.store(part, one.measured(part), 1.0)
    for number in range(2, 2000):
        for part in parts_of(number, [], x_mm=100.0):
            one.store(part, None, share_of(number, 50))
    assert one.data().imag == pytest.approx(100.0, abs=1e-3)
    assert medium.calls <= MOST_WAITING_SWEEPS + 2


def test_data_of_as_many_points_stay_when_the_frequencies_change():
    one = memory()
    for part in parts_of(3, []):
        one.store(part, None, 1.0)
    one.set_frequencies(np.linspace(1e9, 3e9, POINTS))
    assert set(one.data().real.astype(int)) == {3}
    one.set_frequencies(np.linspace(1e9, 3e9, 5))
    assert list(one.data()) == [0] * 5
