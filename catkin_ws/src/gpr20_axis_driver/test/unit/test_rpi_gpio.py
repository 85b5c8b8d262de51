"""The pins of the real robot over RPi.GPIO."""

import dataclasses

import pytest
from axis_machine import X_PARAMETERS, Count, SteppedClock
from case_kit import each_case
from recorded_rpi_gpio import (
    HIGH,
    IN,
    LOW,
    OUT,
    PUD_DOWN,
    PUD_OFF,
    PUD_UP,
    RecordedRpiGpio,
)

from gpr20_axis_driver.low.pins import StepperInterface
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.motion import Ending, LateLimits, Motion, Until, never
from gpr20_survey.axes.ramp import Ramp

SLOW = Ramp(0.005, 0.005, 0.001)


@pytest.fixture
def gpio():
    return RecordedRpiGpio()


@pytest.fixture
def loop(gpio):
    return PulseLoop(gpio, X_PARAMETERS, SteppedClock(), LateLimits.of(X_PARAMETERS), Count())


def test_the_pins_are_set_up_low_and_the_endstop_is_pulled_up(gpio, loop):
    assert ("setup", 13, OUT, PUD_OFF, LOW) in gpio.calls
    assert ("setup", 15, OUT, PUD_OFF, LOW) in gpio.calls
    assert ("setup", 16, IN, PUD_UP, -1) in gpio.calls
    assert gpio.calls[0] == ("setmode", gpio.BOARD)


@each_case("forward, level", [(True, HIGH), (False, LOW)])
def test_the_direction_is_there_before_the_first_step(gpio, loop, forward, level):
    gpio.calls.clear()
    report = loop.run(Motion(forward, 2, SLOW), never)
    assert (report.ending, report.steps_made) == (Ending.COMPLETE, 2)
    pulse = [("output", 15, HIGH), ("output", 15, LOW)]
    assert gpio.calls == [("output", 13, level), *pulse, *pulse]


def test_a_fault_in_the_middle_of_a_pulse_leaves_the_step_pin_low(gpio):
    def fail():
        raise RuntimeError("a fault while the pin is high")

    stepper = StepperInterface(gpio, dir_pin=13, step_pin=15)
    with pytest.raises(RuntimeError):
        stepper.step(fail)
    assert gpio.calls[-2:] == [("output", 15, HIGH), ("output", 15, LOW)]


def test_a_low_sensor_pin_is_a_pressed_endstop(gpio, loop):
    assert not loop.run(Motion(False, 0, SLOW), never).endstop_pressed
    gpio.inputs[16] = LOW
    report = loop.run(Motion(False, 5, SLOW, Until.PRESSED), never)
    assert (report.ending, report.steps_made, report.endstop_pressed) == (Ending.UNTIL, 0, True)


def test_closing_leaves_the_pins_low_and_then_releases_them(gpio, loop):
    loop.run(Motion(True, 1, SLOW), never)
    gpio.calls.clear()
    loop.close()
    assert gpio.calls == [
        ("output", 15, LOW),
        ("output", 13, LOW),
        ("cleanup", [15, 13]),
        ("cleanup", [16]),
    ]
    assert gpio.directions == {}


def opened(gpio, **changes):
    parameters = dataclasses.replace(X_PARAMETERS, **changes)
    return PulseLoop(gpio, parameters, SteppedClock(), LateLimits.of(parameters), Count())


@each_case("pull, resistor", [("up", PUD_UP), ("down", PUD_DOWN), ("none", PUD_OFF)])
def test_the_endstop_is_pulled_as_configured(pull, resistor):
    gpio = RecordedRpiGpio()
    opened(gpio, endstop_pull=pull)
    assert ("setup", 16, IN, resistor, -1) in gpio.calls


@each_case("level, pressed", [(HIGH, True), (LOW, False)])
def test_an_active_high_endstop_is_pressed_when_it_reads_high(level, pressed):
    gpio = RecordedRpiGpio()
    loop = opened(gpio, endstop_active="high")
    gpio.inputs[16] = level
    assert loop.run(Motion(False, 0, SLOW), never).endstop_pressed is pressed


@each_case("forward, level", [(True, LOW), (False, HIGH)])
def test_an_inverted_direction_pin_is_low_for_increasing_coordinates(forward, level):
    gpio = RecordedRpiGpio()
    opened(gpio, invert_direction=True).run(Motion(forward, 1, SLOW), never)
    assert ("output", 13, level) in gpio.calls


@each_case("active, level", [("low", LOW), ("high", HIGH)])
def test_the_motor_driver_is_enabled_before_the_first_step_and_after_the_end(active, level):
    gpio = RecordedRpiGpio()
    loop = opened(gpio, enable_pin=18, enable_active=active)
    enabled = ("setup", 18, OUT, PUD_OFF, level)
    assert enabled in gpio.calls
    loop.run(Motion(True, 1, SLOW), never)
    loop.close()
    assert [call for call in gpio.calls if call[1] == 18] == [enabled]
    assert (gpio.directions, gpio.levels[18]) == ({18: OUT}, level)
