"""The pins of the real robot over RPi.GPIO, and how they may be wired."""

import dataclasses

import pytest
from axis_machine import SHORT, X_PARAMETERS, Count, SteppedClock
from case_kit import each_case
from direct_pulses import DirectPulses
from fault_kit import raises_fault
from recorded_rpi_gpio import (
    HIGH,
    LOW,
    OUT,
    PUD_OFF,
    RecordedRpiGpio,
)

from gpr20_axis_driver.faults import EndstopError
from gpr20_axis_driver.low.pins import StepperInterface
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.motion import Ending, Motion, never
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.carriage import AxisMotor, SimulatedPins, wiring_of
from gpr20_simulator.mid.world.scene import X_AXIS
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import Level
from gpr20_survey.axes.ramp import Ramp
from gpr20_survey.faults import ENDSTOP

SLOW = Ramp(0.005, 0.005, 0.001)


@pytest.fixture
def gpio():
    return RecordedRpiGpio()


@pytest.fixture
def loop(gpio):
    return PulseLoop(gpio, X_PARAMETERS, SteppedClock(), Count())


@each_case("forward, level", [(True, HIGH), (False, LOW)])
def test_the_pins_are_set_up_and_the_direction_is_there_before_the_first_step(
    gpio, loop, forward, level
):
    if forward:
        assert gpio.calls[0] == ("setmode", gpio.BOARD)
        assert {("setup", pin, gpio.OUT, gpio.PUD_OFF, LOW) for pin in (13, 15)} <= {*gpio.calls}
        assert ("setup", 16, gpio.IN, gpio.PUD_UP, -1) in gpio.calls
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
    return PulseLoop(gpio, parameters, SteppedClock(), Count())


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


# Robots that are wired in another way than the built one, and configurations that do not fit.


class WiredAxis:
    """A driver over a simulated axis with this wiring and these parameters."""

    def __init__(self, folder, wiring, parameters):
        self.state = open_shared_state(folder / "world", {AxisId.X: 500})
        self.state.set_steps(AxisId.X, 500)
        mechanics = dataclasses.replace(X_AXIS, **wiring)
        motor = AxisMotor(self.state, AxisId.X, mechanics)
        pins = SimulatedPins(motor, wiring_of(AxisId.X, mechanics))
        axis, count = dataclasses.replace(SHORT, **parameters), Count()
        loop = PulseLoop(pins, axis, SteppedClock(), count)
        self.driver = AxisDriver(axis, DirectPulses(loop, count))


@each_case(
    "wiring, parameters, fault",
    [
        (
            {"endstop_active": Level.HIGH},
            {"endstop_active": "high", "endstop_pull": "down"},
            None,
        ),
        ({}, {"endstop_pull": "none"}, None),
        ({"direction_inverted": True}, {"invert_direction": True}, None),
        (
            {"enable_pin": 18, "enable_active": Level.HIGH},
            {"enable_pin": 18, "enable_active": "high"},
            None,
        ),
        # Pulled to the level that means pressed.
        ({"endstop_active": Level.HIGH}, {"endstop_active": "high"}, ENDSTOP),
        ({"endstop_active": Level.HIGH}, {}, ENDSTOP),
        ({"direction_inverted": True}, {}, ENDSTOP),
        (
            {"enable_pin": 18},
            {"enable_pin": 18, "enable_active": "high"},
            ENDSTOP,
        ),
    ],
)
def test_a_configuration_moves_the_axis_if_it_fits_its_wiring_and_is_an_error_otherwise(
    tmp_path, wiring, parameters, fault
):
    axis = WiredAxis(tmp_path, wiring, parameters)
    if fault is None:
        axis.driver.homing()
        axis.driver.move_to_coordinate(12.34)
        assert axis.state.steps(AxisId.X) == 1234
        return
    with raises_fault(fault, error=EndstopError):
        axis.driver.homing()
    assert not axis.driver.homing_done
