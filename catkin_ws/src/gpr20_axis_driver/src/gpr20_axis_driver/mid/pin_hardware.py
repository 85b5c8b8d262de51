"""A motor and an endstop on pins with the calls of RPi.GPIO."""

from __future__ import annotations

from gpr20_axis_driver.low.endstop_interface import EndstopInterface
from gpr20_axis_driver.low.pins import Pins
from gpr20_axis_driver.low.stepper_interface import StepperInterface
from gpr20_axis_driver.mid.motion import LateLimits, StepCount
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_common.low.clock import Clock
from gpr20_survey.axes.axis_parameters import AxisParameters


def pulse_loop_on_pins(
    pins: Pins, parameters: AxisParameters, clock: Clock, limits: LateLimits, count: StepCount
) -> PulseLoop:
    """Set up the pins of an axis, step and direction low, and return what steps on them."""
    stepper = StepperInterface(pins, parameters.dir_pin, parameters.step_pin)
    endstop = None
    if parameters.sensor_pin is not None:
        endstop = EndstopInterface(pins, parameters.sensor_pin)
    return PulseLoop(stepper, endstop, clock, limits, count)


def late_limits(parameters: AxisParameters) -> LateLimits:
    """Return the limits that the parameters name, for a robot that moves in real time."""
    return LateLimits(parameters.late_limit_s, parameters.gap_limit_s)
