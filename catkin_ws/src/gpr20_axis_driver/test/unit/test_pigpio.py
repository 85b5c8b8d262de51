"""The pins of the real robot over pigpio."""

import contextlib
import dataclasses
import random

import pytest
from axis_machine import X_PARAMETERS, Z_PARAMETERS, Count, SteppedClock
from case_kit import each_case
from direct_pulses import DirectPulses
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded_pigpio import RecordedPigpio
from run_seed import SEED, draws

from gpr20_axis_driver.axis_exceptions import (
    MotionStopped,
    NotHomedError,
    PinLibraryError,
    PulseProcessError,
)
from gpr20_axis_driver.low.pigpio_waves import GPIO_OF_BOARD, lock_wave_transmitter
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.wave_runner import WaveRunner
from gpr20_axis_driver.motion import Ending, Motion, never
from gpr20_common.faults import CONFIGURATION
from gpr20_survey.axes.axis_parameters import BOARD_PINS
from gpr20_survey.axes.ramp import Ramp

DIR, STEP, SENSOR, ENABLE = 27, 22, 23, 24
OUTPUT, UP, DOWN, OFF = 1, 2, 1, 0
RAMP = Ramp(X_PARAMETERS.min_step, X_PARAMETERS.max_step, X_PARAMETERS.delta_step)
STOP_S = 0.1


class Axis:
    """A driver over a daemon that transmits in the time of a clock moved by sleeping."""

    def __init__(self, folder, parameters=X_PARAMETERS):
        self.clock = SteppedClock()
        self.daemon = RecordedPigpio(self.clock)
        self.daemon.inputs = lambda gpio: int(self.steps > -100)
        self.count = Count()
        self.lock = lock_wave_transmitter(folder / "lock")
        self.runner = WaveRunner(self.daemon, self.lock, parameters, self.clock, self.count)
        self.driver = AxisDriver(parameters, DirectPulses(self.runner, self.count))
        # Where the last motion began: edges until then, and the motor's step.
        self._began = (0, 0)
        self._set_direction = self.runner._waves.set_direction
        self.runner._waves.set_direction = self._turn

    @property
    def edges_s(self):
        return self.daemon.rising_edges(STEP)

    @property
    def steps(self):
        """Where the motor is, by the edges on its pins."""
        edges, steps = self._began
        turned = self.daemon.count_rising_edges(STEP) - edges
        return steps + turned * (1 if self.daemon.levels[DIR] else -1)

    def close(self):
        self.runner.close()

    def _turn(self, forward):
        self._began = (self.daemon.count_rising_edges(STEP), self.steps)
        self._set_direction(forward)


@pytest.fixture
def axis(tmp_path):
    axis = Axis(tmp_path)
    yield axis
    axis.lock.close()


def opened(folder, **changes):
    return contextlib.closing(Axis(folder, dataclasses.replace(X_PARAMETERS, **changes)))


@each_case("pull, resistor", [("up", UP), ("down", DOWN), ("none", OFF)])
def test_the_pins_are_set_up_low_and_the_endstop_is_pulled_as_configured(tmp_path, pull, resistor):
    with opened(tmp_path, endstop_pull=pull, enable_pin=18, enable_active="high") as axis:
        assert axis.daemon.modes == {DIR: OUTPUT, STEP: OUTPUT, SENSOR: 0, ENABLE: OUTPUT}
        assert axis.daemon.levels == {DIR: 0, STEP: 0, ENABLE: 1}
        assert axis.daemon.pulls == {SENSOR: resistor}
    # The motor driver stays enabled: the carriage does not slip.
    assert axis.daemon.levels == {DIR: 0, STEP: 0, ENABLE: 1}


def test_the_pulses_of_a_move_come_when_the_ramp_says(axis):
    axis.driver.homing(never)
    before = len(axis.edges_s)
    axis.driver.move_to_coordinate(5.0, never)
    edges_s = axis.edges_s[before:]
    pauses_s = [(later - earlier) / 2 for earlier, later in zip(edges_s, edges_s[1:])]
    assert len(edges_s) == 500
    assert pauses_s == pytest.approx(
        [RAMP.pause_s(min(step, 499 - step)) for step in range(500)][:-1], abs=1e-6
    )


def test_the_count_is_exact_whatever_is_stopped_when(axis):
    chance = random.Random(SEED)
    axis.driver.homing(never)
    for _ in range(draws(15)):
        countdown = iter([False] * chance.randrange(0, 300))
        with contextlib.suppress(MotionStopped):
            axis.driver.move_to_coordinate(
                chance.randrange(0, 2000) / 100, lambda c=countdown: next(c, True)
            )
        assert round(axis.driver.current_coord * 100) == axis.steps
        assert axis.daemon.level(STEP) == 0


@given(st.floats(0.0, 3.0))
@settings(max_examples=draws(8))
def test_a_stop_takes_effect_within_its_limit_and_the_ramp(tmp_path_factory, request_s):
    axis = Axis(tmp_path_factory.mktemp("lock"))
    axis.driver._motions.place(0)
    axis.driver._homing_done = True
    begin_s = axis.clock.now_s()
    with contextlib.suppress(MotionStopped):
        axis.driver.move_to_coordinate(100.0, lambda: axis.clock.now_s() >= begin_s + request_s)
    ramp_s = RAMP.duration_s(2 * RAMP.braking_steps(RAMP.min_pause_s)) / 2.0
    assert axis.clock.now_s() - begin_s - request_s < ramp_s + STOP_S
    axis.lock.close()


def test_a_daemon_left_without_waves_slows_the_rest_down(axis):
    axis.driver.homing(never)
    oversleep(axis, 200, 0.08)
    axis.driver.move_to_coordinate(10.0, never)
    assert axis.steps == 1000
    assert axis.driver.last_motion.lateness.slowed == 1
    edges_s = axis.edges_s[-1000:]
    pauses_s = [(later - earlier) / 2 for earlier, later in zip(edges_s, edges_s[1:])]
    for earlier_s, later_s in zip(pauses_s, pauses_s[1:]):
        slow_s = min(earlier_s, RAMP.max_pause_s)
        assert later_s >= slow_s - RAMP.delta_s - X_PARAMETERS.late_limit_s


@each_case("delay_s, dropped", [(0.5, None), (0.0, 5)])
def test_a_daemon_left_without_waves_for_long_or_that_drops_one_makes_the_position_unknown(
    tmp_path, delay_s, dropped
):
    with opened(tmp_path) as axis:
        axis.driver.homing(never)
        oversleep(axis, 200, delay_s)
        axis.daemon.lost_after = dropped and len(axis.daemon.sendings) + dropped
        with pytest.raises(NotHomedError):
            axis.driver.move_to_coordinate(10.0, never)
        assert not axis.driver.homing_done and not axis.count.trusted


def test_the_endstop_pressed_in_a_move_ends_it(axis):
    axis.driver.homing(never)
    axis.driver.move_to_coordinate(10.0, never)
    axis.daemon.inputs = lambda gpio: int(axis.steps > 500)
    report = axis.runner.run(Motion(False, 1000, RAMP, guarded=True), never)
    assert report.ending is Ending.PRESSED
    # Two waves of 25 ms at most pass before it is seen.
    assert 480 <= axis.steps <= 500
    assert axis.daemon.level(STEP) == 0


def test_a_daemon_that_dies_or_does_not_run_is_an_error_that_names_it(axis):
    axis.driver.homing(never)
    axis.daemon.running = False
    with raises_fault(CONFIGURATION, error=PulseProcessError):
        axis.driver.move_to_coordinate(1.0, never)
    with raises_fault(CONFIGURATION, error=PinLibraryError):
        WaveRunner(axis.daemon, axis.lock, Z_PARAMETERS, SteppedClock(), Count())


def test_only_one_axis_gets_the_transmitter_and_closing_leaves_it_free_and_the_pins_low(
    axis, tmp_path
):
    axis.driver.homing(never)
    with raises_fault(CONFIGURATION, error=PinLibraryError):
        lock_wave_transmitter(tmp_path / "lock")
    axis.runner.close()
    assert axis.daemon.levels == {DIR: 0, STEP: 0}
    lock_wave_transmitter(tmp_path / "lock").close()


def oversleep(axis, sleeps, delay_s):
    """Let one sleep of the runner be too long."""
    delays = iter([0.0] * sleeps + [delay_s])
    axis.clock.oversleep_s = lambda: next(delays, 0.0)


def test_every_pin_of_the_header_has_its_gpio():
    assert set(GPIO_OF_BOARD) == BOARD_PINS
    assert len(set(GPIO_OF_BOARD.values())) == len(GPIO_OF_BOARD)
