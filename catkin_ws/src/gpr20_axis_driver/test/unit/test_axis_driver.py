"""One axis: where its moves and its homing end, what ends them, and since which zero it counts."""

from __future__ import annotations

import contextlib
import itertools
import math
import random
import threading
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor

import pytest
from axis_machine import SHORT, X_PARAMETERS, Z_PARAMETERS, Axis
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from run_seed import SEED, draws

from gpr20_axis_driver import faults
from gpr20_axis_driver.faults import (
    AxisBusyError,
    EndstopError,
    MotionStopped,
    NotHomedError,
    TravelError,
)
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.motion import never
from gpr20_common.faults import ASKED_FOR, IN_USE, NOT_ALLOWED
from gpr20_survey.axes import UNKNOWN_ZERO, Ramp
from gpr20_survey.faults import ENDSTOP, NOT_HOMED

TRAVEL_STEPS = SHORT.distance_steps(SHORT.max_coord)
BACKOFF_STEPS = SHORT.distance_steps(SHORT.homing_backoff)
MARGIN_STEPS = SHORT.distance_steps(SHORT.homing_margin)
LATE_S = X_PARAMETERS.late_limit_s
GAP_S = X_PARAMETERS.gap_limit_s
RAMP = Ramp(X_PARAMETERS.min_step, X_PARAMETERS.max_step, X_PARAMETERS.delta_step)
ROUNDING_S = 1e-9


class AnyMotions:
    """An axis with an endstop against a model: is it homed, is its place known, which zero."""

    def __init__(self, chance):
        self.chance = chance
        self.axis = Axis(SHORT, chance.randrange(-150, TRAVEL_STEPS))
        self.machine, self.driver = self.axis.machine, self.axis.driver
        self.homed, self.known, self.zeros = False, False, 0

    def after(self, pulses):
        """Return what requests a stop after so many pulses from now on; None: never."""
        made = len(self.machine.pulses)
        return lambda: pulses is not None and len(self.machine.pulses) - made >= pulses

    def move(self):
        """Move; after some pulses a stop is requested, or the endstop closes."""
        to, pressed = self.chance.randrange(TRAVEL_STEPS + 1), self.chance.random() < 0.4
        pulses = self.chance.choice([None, self.chance.randrange(600)])
        self.machine.pulses.clear()
        start, stop = self.machine.steps, self.after(pulses)

        def press():
            self.machine.stuck = stop() or None
            return False

        try:
            self.driver.move_to_coordinate(to / 100, press if pressed else stop)
        except NotHomedError:
            assert not self.homed and self.machine.steps == start
        except MotionStopped as error:
            assert not pressed and self.machine.steps != to
            assert error.message.fault_code == ASKED_FOR.code
        except EndstopError:
            # It is seen before the pulse after the next one.
            assert pressed and abs(self.machine.steps - start) == pulses + 1
            self.homed = self.known = False
        else:
            assert self.homed and self.machine.steps == to
            # Too near for either: a stop brakes over 35 steps.
            assert pulses is None or abs(to - start) <= pulses + (1 if pressed else 36)
        self.machine.stuck = None
        # It speeds up and slows down as its ramp does, also when it is stopped.
        pauses_s = self.axis.pauses_s
        slow_s = [RAMP.max_pause_s - RAMP.delta_s] if pauses_s and not pressed else []
        for one_s, next_s in zip(pauses_s, [*pauses_s[1:], *slow_s]):
            assert abs(next_s - one_s) <= RAMP.delta_s + ROUNDING_S

    def home(self):
        self.homed = False
        with contextlib.suppress(MotionStopped):
            self.driver.homing(self.after(self.chance.choice([None, self.chance.randrange(600)])))
            self.homed, self.known, self.zeros = True, True, self.zeros + 1
            assert self.machine.steps == 0

    def home_while_the_endstop_stays_open(self):
        """The carriage is not pushed further than necessary."""
        self.machine.stuck, made = False, len(self.machine.pulses)
        whole = int(1.05 * TRAVEL_STEPS)
        most = min(whole, max(0, self.machine.steps) + MARGIN_STEPS) if self.known else whole
        with raises_fault(ENDSTOP, f"{(most + BACKOFF_STEPS) / 100:g} mm", error=EndstopError):
            self.driver.homing(never)
        assert len(self.machine.pulses) - made == most + BACKOFF_STEPS
        self.homed = self.known = False
        # It was stopped by its end.
        self.machine.stuck, self.machine.steps = None, max(-150, self.machine.steps)

    def start_the_node_again(self):
        self.driver, self.homed = AxisDriver(SHORT, self.axis.pulses), False

    def check(self):
        position = self.driver.position
        assert (position.homed, position.zero.number) == (self.homed, self.zeros)
        assert self.axis.pulses.trusted == self.known and not self.driver.moving
        assert not self.known or round(position.coordinate * 100) == self.machine.steps


def test_the_coordinate_is_exact_while_it_is_known_and_only_a_homing_begins_a_zero():
    chance = random.Random(SEED)
    for _axis in range(draws(10)):
        axis = AnyMotions(chance)
        others = [axis.home_while_the_endstop_stays_open, axis.start_the_node_again]
        for _act in range(30):
            chance.choice([axis.move] * 6 + [axis.home] * 4 + others)()
            axis.check()


def homed_axis():
    axis = Axis(X_PARAMETERS, start_steps=0)
    axis.driver.homing(never)
    axis.machine.pulses.clear()
    axis.machine.edges_s.clear()
    return axis


@pytest.fixture
def axis():
    return homed_axis()


@each_case("target", [-0.01, 650.01, math.nan, math.inf, -math.inf])
def test_a_target_outside_the_axis_is_refused_and_moves_nothing(axis, target):
    with raises_fault(NOT_ALLOWED, 0, 650, "mm", error=TravelError):
        axis.driver.move_to_coordinate(target, never)
    assert axis.machine.pulses == []


def test_a_second_motion_is_refused_while_one_is_under_way_and_works_after_a_failure(axis):
    def try_another():
        for motion in (lambda: axis.driver.move_to_coordinate(1.0, never), axis.driver.homing):
            with raises_fault(IN_USE, error=AxisBusyError):
                motion()
        raise RuntimeError("a fault in the middle of a move")

    with pytest.raises(RuntimeError, match="in the middle"):
        axis.driver.move_to_coordinate(5.0, try_another)
    assert not axis.driver.moving
    axis.driver.move_to_coordinate(5.0, never)
    assert axis.machine.steps == 500


def test_the_endstop_is_touched_twice_at_the_lowest_speed():
    axis = Axis(X_PARAMETERS, start_steps=0)
    axis.driver.homing(never)
    turns = [direction for _time, direction in axis.machine.pulses]
    assert turns == [-1] * 100 + [1] * 100 + [-1] * 100 + [1] * 100
    assert min(axis.pauses_s) == pytest.approx(X_PARAMETERS.max_step)


def does_not_turn(machine):
    machine.lose_steps, machine.steps = True, -100


def switches_elsewhere(machine):
    # Once the carriage has backed off from the first touch.
    machine.endstop_steps = -30 if len(machine.pulses) >= 700 else -100


def stays_pressed(machine):
    machine.stuck = True if len(machine.pulses) > 620 else None


@each_case("odd", [does_not_turn, switches_elsewhere, stays_pressed])
def test_a_motor_that_does_not_turn_or_an_endstop_that_is_not_reliable_is_an_error(odd):
    axis = Axis(X_PARAMETERS)
    with raises_fault(ENDSTOP, error=EndstopError):
        axis.driver.homing(lambda: bool(odd(axis.machine)))
    assert not axis.driver.homing_done


# Of an axis that has no endstop.


def test_its_zero_is_where_it_was_set_and_a_homing_turns_to_it():
    axis = Axis(Z_PARAMETERS, start_steps=0)
    assert axis.driver.position.zero == UNKNOWN_ZERO
    axis.driver.set_zero()
    first = axis.driver.position.zero
    axis.driver.move_to_coordinate(90.0, never)
    assert axis.driver.position.zero == first
    axis.driver.set_zero()
    second = axis.driver.position.zero
    axis.driver.move_to_coordinate(90.0, never)
    # One that was stopped is not homed, and continues later.
    with pytest.raises(MotionStopped):
        axis.driver.homing(lambda: len(axis.machine.pulses) >= 110)
    assert not axis.driver.homing_done
    axis.driver.homing(never)
    third = axis.driver.position.zero
    assert (axis.driver.homing_done, axis.driver.current_coord) == (True, 0.0)
    assert axis.machine.steps == 50
    assert [one.number for one in (first, second, third)] == [1, 2, 3]
    # Nothing found it now.
    assert 0 < first.time_us <= second.time_us == third.time_us


def test_the_zero_is_set_neither_in_the_middle_of_a_turn_nor_on_an_axis_with_an_endstop():
    axis = Axis(Z_PARAMETERS, start_steps=0)
    axis.driver.set_zero()

    def set_zero():
        with pytest.raises(AxisBusyError):
            axis.driver.set_zero()
        return False

    axis.driver.move_to_coordinate(90.0, set_zero)
    assert axis.driver.current_coord == 90.0
    with raises_fault(NOT_HOMED, error=EndstopError):
        Axis(X_PARAMETERS).driver.set_zero()


def test_no_reading_has_the_coordinate_of_one_zero_and_the_number_of_another():
    axis = Axis(Z_PARAMETERS, start_steps=0)
    ended, coordinates = threading.Event(), defaultdict(list)

    def read():
        while not ended.is_set():
            position = axis.driver.position
            coordinates[position.zero.number].append(position.coordinate)

    with ThreadPoolExecutor(1) as pool:
        reading = pool.submit(read)
        while len(coordinates) < draws(25):
            axis.driver.set_zero()
            axis.driver.move_to_coordinate(1.8, never)
        ended.set()
        reading.result()
    # Within one zero the axis turns from 0 to 1.8 and never back.
    for number, seen in coordinates.items():
        assert seen == sorted(seen) and set(seen) <= {0.0, 1.8}, number


# What late wake-ups do to a motion.


def move(axis, steps, delays_s):
    """Move while the sleeps are too long by these times, then punctual."""
    delays = itertools.chain(delays_s, itertools.repeat(0.0))
    axis.clock.oversleep_s = lambda: next(delays)
    axis.driver.move_to_coordinate(steps / 100, never)
    axis.clock.oversleep_s = lambda: 0.0


def at(index, delay_s):
    """One long sleep after so many punctual ones; a step has two."""
    return [0.0] * index + [delay_s]


on_time = st.lists(st.floats(0.0, LATE_S), max_size=100)
delays = st.lists(st.one_of(st.floats(0.0, LATE_S), st.floats(0.0, 0.4 * GAP_S)), max_size=100)


@given(st.integers(1, 150), st.one_of(on_time, delays))
def test_no_lateness_is_followed_by_a_burst_and_the_axis_speeds_up_as_slowly_as_its_ramp(
    steps, delays_s
):
    axis = homed_axis()
    begin_s = axis.clock.time_s
    move(axis, steps, delays_s)
    assert axis.machine.steps == steps
    if max(delays_s, default=0.0) <= LATE_S:
        assert axis.clock.time_s - begin_s == pytest.approx(RAMP.duration_s(steps))
        assert axis.driver.last_motion.lateness.slowed == 0
    edges_s = axis.machine.edges_s
    between_s = [later - earlier for earlier, later in zip(edges_s, edges_s[1:])]
    assert all(pause_s >= RAMP.min_pause_s - LATE_S - ROUNDING_S for pause_s in between_s)
    for earlier_s, later_s in zip(axis.pauses_s, axis.pauses_s[1:]):
        slow_s = min(earlier_s, RAMP.max_pause_s)
        assert later_s >= slow_s - RAMP.delta_s - LATE_S - ROUNDING_S


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
    # At the lowest speed it loses nothing.
    axis = homed_axis()
    move(axis, 300, at(2, 1.0))
    assert (axis.machine.steps, axis.driver.homing_done) == (300, True)
