"""The pins of the real robot over RPi.GPIO."""

import pytest
from axis_machine import X_PARAMETERS, Count, SteppedClock, never
from recorded_rpi_gpio import HIGH, IN, LOW, OUT, PUD_OFF, PUD_UP, RecordedRpiGpio

from gpr20_axis_driver.mid.motion import Ending, Motion, Until
from gpr20_axis_driver.mid.pin_hardware import late_limits, pulse_loop_on_pins
from gpr20_survey.axes.ramp import Ramp

SLOW = Ramp(0.005, 0.005, 0.001)


@pytest.fixture
def gpio():
    return RecordedRpiGpio()


@pytest.fixture
def loop(gpio):
    limits = late_limits(X_PARAMETERS)
    return pulse_loop_on_pins(gpio, X_PARAMETERS, SteppedClock(), limits, Count())


def test_the_pins_are_set_up_low_and_the_endstop_is_pulled_up(gpio, loop):
    assert ("setup", 13, OUT, PUD_OFF, LOW) in gpio.calls
    assert ("setup", 15, OUT, PUD_OFF, LOW) in gpio.calls
    assert ("setup", 16, IN, PUD_UP, -1) in gpio.calls
    assert gpio.calls[0] == ("setmode", gpio.BOARD)


@pytest.mark.parametrize("forward, level", [(True, HIGH), (False, LOW)])
def test_the_direction_is_there_before_the_first_step(gpio, loop, forward, level):
    gpio.calls.clear()
    report = loop.run(Motion(forward, 2, SLOW), never)
    assert (report.ending, report.steps_made) == (Ending.COMPLETE, 2)
    pulse = [("output", 15, HIGH), ("output", 15, LOW)]
    # The pin is driven low once more when the motion ends, whatever ended it.
    assert gpio.calls == [("output", 13, level), *pulse, *pulse, ("output", 15, LOW)]


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
