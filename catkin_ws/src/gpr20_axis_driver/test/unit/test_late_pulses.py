"""What late wake-ups do to a motion."""

import itertools

import pytest
from axis_machine import X_PARAMETERS, Axis
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_axis_driver import faults
from gpr20_axis_driver.axis_exceptions import NotHomedError
from gpr20_axis_driver.motion import never
from gpr20_survey.axes.ramp import Ramp

LATE_S = X_PARAMETERS.late_limit_s
GAP_S = X_PARAMETERS.gap_limit_s
RAMP = Ramp(X_PARAMETERS.min_step, X_PARAMETERS.max_step, X_PARAMETERS.delta_step)
ROUNDING_S = 1e-9


def homed_axis():
    axis = Axis(X_PARAMETERS, start_steps=0)
    axis.driver.homing(never)
    axis.machine.pulses.clear()
    axis.machine.edges_s.clear()
    return axis


def oversleep(axis, delays_s):
    """Let the sleeps be too long by these times, then punctual."""
    delays = itertools.chain(delays_s, itertools.repeat(0.0))
    axis.clock.oversleep_s = lambda: next(delays)


def move(axis, steps, delays_s):
    oversleep(axis, delays_s)
    axis.driver.move_to_coordinate(steps / 100, never)
    axis.clock.oversleep_s = lambda: 0.0


def at(index, delay_s):
    """One long sleep after so many punctual ones; a step has two."""
    return [0.0] * index + [delay_s]


delays = st.lists(
    st.one_of(st.just(0.0), st.floats(0.0, LATE_S), st.floats(0.0, 0.4 * GAP_S)), max_size=100
)


@given(st.integers(1, 150), delays)
def test_no_lateness_is_followed_by_a_burst_and_the_axis_speeds_up_as_slowly_as_its_ramp(
    steps, delays_s
):
    axis = homed_axis()
    move(axis, steps, delays_s)
    assert axis.machine.steps == steps
    edges_s = axis.machine.edges_s
    between_s = [later - earlier for earlier, later in zip(edges_s, edges_s[1:])]
    assert all(pause_s >= RAMP.min_pause_s - LATE_S - ROUNDING_S for pause_s in between_s)
    for earlier_s, later_s in zip(axis.pauses_s, axis.pauses_s[1:]):
        slow_s = min(earlier_s, RAMP.max_pause_s)
        assert later_s >= slow_s - RAMP.delta_s - LATE_S - ROUNDING_S


@given(st.lists(st.floats(0.0, LATE_S), max_size=100))
def test_lateness_below_the_limit_does_not_delay_the_rest(delays_s):
    axis = homed_axis()
    begin_s = axis.clock.time_s
    move(axis, 200, delays_s)
    assert axis.clock.time_s - begin_s == pytest.approx(RAMP.duration_s(200))
    assert axis.driver.last_motion.lateness.slowed == 0


@each_case("edge, pauses_s", [(200, [0.0015, 0.0035, 0.0034]), (201, [0.0015, 0.0015, 0.0035])])
def test_one_late_edge_shifts_the_rest_and_slows_it_down(edge, pauses_s):
    axis = homed_axis()
    # That of the 101st pulse, long at top speed.
    move(axis, 300, at(edge, 0.004))
    assert axis.pauses_s[98:101] == pytest.approx(pauses_s)
    lateness = axis.driver.last_motion.lateness
    assert (lateness.slowed, axis.machine.steps) == (1, 300)


@each_case("delays_s", [at(200, 0.06), at(201, 0.06), [*at(201, 0.03), 0.03]])
def test_a_gap_at_speed_ends_the_move_and_the_position_is_no_longer_trusted(delays_s):
    axis = homed_axis()
    # Two delays of one step add up.
    with raises_fault(faults.PULSE_LATE, 60, error=NotHomedError):
        move(axis, 300, delays_s)
    assert not axis.driver.homing_done and not axis.pulses.trusted
    assert len(axis.machine.pulses) in (100, 101)
    assert axis.machine.levels[X_PARAMETERS.step_pin] == axis.machine.LOW
    with pytest.raises(NotHomedError):
        axis.driver.move_to_coordinate(0.0, never)


def test_a_gap_at_the_lowest_speed_loses_nothing():
    axis = homed_axis()
    move(axis, 300, at(2, 1.0))
    assert axis.machine.steps == 300
    assert axis.driver.homing_done
