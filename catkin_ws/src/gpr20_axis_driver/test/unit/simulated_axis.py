"""A driver whose pulses are made by a real process and move the carriage of a simulated world."""

from __future__ import annotations

import time
from pathlib import Path

from axis_machine import X_PARAMETERS, Z_PARAMETERS

from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.pulse_process import PulseProcess
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.axis_hardware import SimulatedHardware
from gpr20_simulator.mid.world.scene import X_AXIS, Z_AXIS
from gpr20_survey.axes.axis_id import AxisId

LIMIT_S = 30.0
PARAMETERS = {AxisId.X: X_PARAMETERS, AxisId.Z: Z_PARAMETERS}
MECHANICS = {AxisId.X: X_AXIS, AxisId.Z: Z_AXIS}


def simulated_hardware(folder: Path, axis: AxisId, time_scale: float) -> SimulatedHardware:
    """Return what an axis of a simulated robot in this folder is wired to."""
    path = folder / "world"
    world = open_shared_state(path, {AxisId.X: 200})
    return SimulatedHardware(
        PARAMETERS[axis], path, axis, MECHANICS[axis], time_scale, world.steps(axis)
    )


class SimulatedAxis:
    """The driver, its pulses, and the truth beside them."""

    def __init__(self, folder: Path, axis: AxisId, time_scale: float) -> None:
        self.axis = axis
        self.hardware = simulated_hardware(folder, axis, time_scale)
        self.world = open_shared_state(self.hardware.state_path)
        self.pulses = PulseProcess(self.hardware)
        self.driver = AxisDriver(PARAMETERS[axis], self.pulses)

    @property
    def true_steps(self) -> int:
        return self.world.steps(self.axis)

    @property
    def pins_low(self) -> bool:
        return self.world.pins_low(self.axis)


def wait_until(condition) -> None:
    """Return once the condition holds; fail after a while."""
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, "the condition never held"
        time.sleep(0.002)


def exists(process_id: int) -> bool:
    """Return whether there is such a process, a zombie included."""
    return Path(f"/proc/{process_id}").exists()
