"""Robots that are wired in another way than the built one, and configurations that do not fit."""

import dataclasses

from axis_machine import SHORT, Count, SteppedClock
from case_kit import each_case
from direct_pulses import DirectPulses
from fault_kit import raises_fault

from gpr20_axis_driver import faults
from gpr20_axis_driver.axis_exceptions import EndstopError
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.motion import LateLimits
from gpr20_simulator.low.pins import SimulatedPins
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.carriage import AxisMotor, wiring_of
from gpr20_simulator.mid.world.scene import X_AXIS
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import Level

LOW, HIGH = Level.LOW, Level.HIGH


class WiredAxis:
    """A driver over a simulated axis with this wiring and these parameters."""

    def __init__(self, folder, wiring, parameters):
        self.state = open_shared_state(folder / "world", {AxisId.X: 500})
        self.state.set_steps(AxisId.X, 500)
        mechanics = dataclasses.replace(X_AXIS, **wiring)
        motor = AxisMotor(self.state, AxisId.X, mechanics)
        pins = SimulatedPins(motor, wiring_of(AxisId.X, mechanics))
        axis, count = dataclasses.replace(SHORT, **parameters), Count()
        loop = PulseLoop(pins, axis, SteppedClock(), LateLimits.of(axis), count)
        self.driver = AxisDriver(axis, DirectPulses(loop, count))


@each_case(
    "wiring, parameters",
    [
        ({"endstop_active": HIGH}, {"endstop_active": "high", "endstop_pull": "down"}),
        ({"endstop_active": HIGH}, {"endstop_active": "high", "endstop_pull": "none"}),
        ({}, {"endstop_pull": "none"}),
        ({"direction_inverted": True}, {"invert_direction": True}),
        ({"enable_pin": 18}, {"enable_pin": 18}),
        (
            {"enable_pin": 18, "enable_active": HIGH},
            {"enable_pin": 18, "enable_active": "high"},
        ),
    ],
)
def test_a_configuration_that_fits_the_wiring_moves_the_axis(tmp_path, wiring, parameters):
    axis = WiredAxis(tmp_path, wiring, parameters)
    axis.driver.homing()
    axis.driver.move_to_coordinate(12.34)
    assert axis.state.steps(AxisId.X) == 1234


@each_case(
    "wiring, parameters, fault",
    [
        # Pulled to the level that means pressed.
        ({"endstop_active": HIGH}, {"endstop_active": "high"}, faults.ENDSTOP_STUCK),
        ({"endstop_active": HIGH}, {}, faults.ENDSTOP_NOT_REACHED),
        ({}, {"endstop_active": "high"}, faults.ENDSTOP_STUCK),
        ({"direction_inverted": True}, {}, faults.ENDSTOP_NOT_REACHED),
        ({"enable_pin": 18}, {}, faults.ENDSTOP_NOT_REACHED),
        (
            {"enable_pin": 18},
            {"enable_pin": 18, "enable_active": "high"},
            faults.ENDSTOP_NOT_REACHED,
        ),
    ],
)
def test_a_configuration_that_does_not_fit_is_an_error(tmp_path, wiring, parameters, fault):
    axis = WiredAxis(tmp_path, wiring, parameters)
    with raises_fault(fault, error=EndstopError):
        axis.driver.homing()
    assert not axis.driver.homing_done
