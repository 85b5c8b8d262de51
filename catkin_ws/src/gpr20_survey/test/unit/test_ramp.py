"""The pauses of a move."""

import itertools

import pytest
from case_kit import each_case
from hypothesis import example, given
from hypothesis import strategies as st

from gpr20_survey.axes import ROUNDING, Ramp

TOLERANCE_S = 1e-12


def pauses_of(ramp, steps):
    """Return the pause of each step of a move [s]: up the ramp, at the top, and down again."""
    return [ramp.pause_s(min(step, steps - 1 - step)) for step in range(steps)]


@st.composite
def ramps(draw):
    min_pause_s = draw(st.floats(1e-5, 0.05))
    max_pause_s = min_pause_s + draw(st.floats(0.0, 0.05))
    return Ramp(min_pause_s, max_pause_s, draw(st.floats(1e-5, 0.1)))


@given(ramps(), st.integers(1, 2000))
def test_a_move_of_n_steps_has_n_pulses_that_begin_and_end_slowly_within_the_bounds(ramp, steps):
    pauses_s = pauses_of(ramp, steps)
    assert len(pauses_s) == steps
    assert pauses_s[0] == pauses_s[-1] == ramp.max_pause_s
    assert all(ramp.min_pause_s <= pause_s <= ramp.max_pause_s for pause_s in pauses_s)
    for earlier, later in zip(pauses_s, pauses_s[1:]):
        assert abs(later - earlier) <= ramp.delta_s + TOLERANCE_S


def fastest_duration_s(ramp, steps, levels):
    """The shortest of all allowed schedules, found by trying every one."""
    best = float("inf")
    for schedule in itertools.product(levels, repeat=steps):
        ends = schedule[0] == schedule[-1] == ramp.max_pause_s
        smooth = all(
            abs(a - b) <= ramp.delta_s + TOLERANCE_S for a, b in zip(schedule, schedule[1:])
        )
        if ends and smooth:
            best = min(best, 2.0 * sum(schedule))
    return best


@each_case("steps", range(1, 8))
def test_no_allowed_schedule_is_faster(steps):
    ramp = Ramp(0.02, 0.05, 0.01)
    best = fastest_duration_s(ramp, steps, [0.02, 0.03, 0.04, 0.05])
    assert 2.0 * sum(pauses_of(ramp, steps)) == pytest.approx(best)


@given(ramps(), st.integers(0, 2000))
@example(Ramp(6.103515625e-05, 6.103525520576856e-05, 0.099609375), 6)
def test_the_duration_is_the_sum_of_the_pauses(ramp, steps):
    # A ramp that is lower than a rounding error counts as none.
    rounding_s = 2.0 * steps * ROUNDING * ramp.delta_s
    expected_s = pytest.approx(2.0 * sum(pauses_of(ramp, steps)), rel=1e-6, abs=rounding_s)
    assert ramp.duration_s(steps) == expected_s


@given(ramps(), st.integers(1, 200))
def test_braking_ends_at_the_lowest_speed_within_the_allowed_changes(ramp, step):
    pause_s = pauses_of(ramp, 400)[step]
    steps = ramp.braking_steps(pause_s)
    braking = [pause_s, *(ramp.pause_s(left) for left in reversed(range(steps)))]
    # A ramp that is lower than a rounding error counts as none.
    rounding_s = ROUNDING * ramp.delta_s
    assert braking[-1] == pytest.approx(ramp.max_pause_s, rel=1e-6, abs=rounding_s)
    for earlier, later in zip(braking, braking[1:]):
        assert -TOLERANCE_S <= later - earlier <= ramp.delta_s + TOLERANCE_S


@given(ramps(), st.floats(0.0, 0.2))
def test_after_a_gap_the_next_pause_is_the_shortest_that_the_ramp_allows(ramp, pause_s):
    height = ramp.height_after(pause_s)
    slow_s = min(max(pause_s, ramp.min_pause_s), ramp.max_pause_s)
    assert ramp.pause_s(height) >= slow_s - ramp.delta_s - 1e-9 * ramp.delta_s - TOLERANCE_S
    assert height == 0 or ramp.max_pause_s - ramp.delta_s * height < pause_s + TOLERANCE_S
