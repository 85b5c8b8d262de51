"""The pins of the real robot over RPi.GPIO, and how they may be wired."""

import contextlib
import dataclasses

import pytest
from axis_machine import SHORT, X_PARAMETERS, Axis, Count, RecordedRpiGpio, SteppedClock
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_axis_driver.faults import EndstopError
from gpr20_axis_driver.low.pins import StepperInterface
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.motion import Ending, Motion, never
from gpr20_survey.axes import Ramp
from gpr20_survey.faults import ENDSTOP

SLOW = Ramp(0.005, 0.005, 0.001)


def opened(gpio, **changes):
    parameters = dataclasses.replace(X_PARAMETERS, **changes)
    return PulseLoop(gpio, parameters, SteppedClock(), Count())


@each_case("forward", [True, False])
def test_the_direction_is_there_before_the_first_step_and_the_pins_end_low(forward):
    gpio = RecordedRpiGpio()
    loop = opened(gpio)
    assert gpio.calls[0] == ("setmode", gpio.BOARD)
    outputs = {("setup", pin, gpio.OUT, gpio.PUD_OFF, gpio.LOW) for pin in (13, 15)}
    assert {*gpio.calls} >= {*outputs, ("setup", 16, gpio.IN, gpio.PUD_UP, -1)}
    gpio.calls.clear()
    report = loop.run(Motion(forward, 2, SLOW), never)
    loop.close()
    assert (report.ending, report.steps_made) == (Ending.COMPLETE, 2)
    pulse = [("output", 15, gpio.HIGH), ("output", 15, gpio.LOW)]
    low = [("output", 15, gpio.LOW), ("output", 13, gpio.LOW)]
    released = [("cleanup", [15, 13]), ("cleanup", [16])]
    assert gpio.calls == [("output", 13, int(forward)), *pulse, *pulse, *low, *released]
    assert gpio.directions == {}


def test_a_fault_in_the_middle_of_a_pulse_leaves_the_step_pin_low():
    def fail():
        raise RuntimeError("a fault while the pin is high")

    gpio = RecordedRpiGpio()
    stepper = StepperInterface(gpio, dir_pin=13, step_pin=15)
    with pytest.raises(RuntimeError):
        stepper.step(fail)
    assert gpio.calls[-2:] == [("output", 15, gpio.HIGH), ("output", 15, gpio.LOW)]


@each_case("active", ["low", "high"])
def test_the_motor_driver_is_enabled_before_the_first_step_and_after_the_end(active):
    gpio = RecordedRpiGpio()
    level = gpio.HIGH if active == "high" else gpio.LOW
    loop = opened(gpio, enable_pin=18, enable_active=active)
    enabled = ("setup", 18, gpio.OUT, gpio.PUD_OFF, level)
    assert enabled in gpio.calls
    loop.run(Motion(True, 1, SLOW), never)
    loop.close()
    assert [call for call in gpio.calls if call[1] == 18] == [enabled]
    assert (gpio.directions, gpio.levels[18]) == ({18: gpio.OUT}, level)


# Robots that are wired in another way than the built one, and configurations that do not fit.


HIGH, INVERTED = {"endstop_active": "high"}, {"invert_direction": True}
ENABLED_HIGH = {"enable_pin": 18, "enable_active": "high"}


@each_case(
    "wiring, parameters, fits",
    [
        (HIGH, {**HIGH, "endstop_pull": "down"}, True),
        (INVERTED, INVERTED, True),
        (ENABLED_HIGH, ENABLED_HIGH, True),
        (HIGH, {}, False),
        (INVERTED, {}, False),
        ({"enable_pin": 18}, ENABLED_HIGH, False),
    ],
)
def test_a_configuration_moves_the_axis_if_it_fits_its_wiring_and_is_an_error_otherwise(
    wiring, parameters, fits
):
    wired, configured = (dataclasses.replace(SHORT, **one) for one in (wiring, parameters))
    axis = Axis(configured, wired=wired)
    with contextlib.nullcontext() if fits else raises_fault(ENDSTOP, error=EndstopError):
        axis.driver.homing()
        axis.driver.move_to_coordinate(12.34)
    assert axis.driver.homing_done == fits == (axis.machine.steps == 1234)
