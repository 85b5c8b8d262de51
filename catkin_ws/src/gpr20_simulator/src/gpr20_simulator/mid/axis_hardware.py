"""What the driver of one axis is wired to on the simulated robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Optional

from gpr20_common.low.clock import Clock
from gpr20_common.mid.node_facts import Hardware
from gpr20_simulator.low.scaled_clock import ScaledClock
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.carriage import AxisMotor, SimulatedPins, wiring_of
from gpr20_simulator.mid.world.scene import AxisMechanics
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters


@dataclass(frozen=True)
class SimulatedHardware:
    """Pins whose pulses move the simulated carriage; an `AxisHardware`.

    Attributes:
        parameters: The axis's parameters.
        state_path: The file of the shared state.
        axis: Which axis this is.
        mechanics: What its motor moves.
        time_scale: How many times faster than the real robot it moves.
        first_steps: Where the motor is when the robot is switched on [motor steps].
    """

    parameters: AxisParameters
    state_path: Path
    axis: AxisId
    mechanics: AxisMechanics
    time_scale: float
    first_steps: Optional[int]

    @property
    def description(self) -> Hardware:
        """What it is."""
        return Hardware("simulated DRV8825", simulated=True, time_scale=self.time_scale)

    @property
    def clock(self) -> Clock:
        """The robot's clock."""
        return ScaledClock(self.time_scale)

    @property
    def realtime(self) -> bool:
        """Only a robot as fast as the real one needs punctual pulses."""
        return self.time_scale == 1.0

    @property
    def step_file(self) -> Path:
        """The steps are forgotten with the shared state, whatever file the robot would have."""
        return self.state_path.with_name(f"{self.state_path.name}_{self.axis.value}_steps")

    def open_pins(self) -> SimulatedPins:
        """Open the pins; called in the process that makes the pulses."""
        motor = AxisMotor(open_shared_state(self.state_path, {}), self.axis, self.mechanics)
        return SimulatedPins(motor, wiring_of(self.axis, self.mechanics))
