"""What is no software of the robot: carriage, ground and instrument, in this process.

The seconds of the instrument pass only while its driver waits, so no test depends on the speed of
the computer. A `World` outlives the robots that a test kills.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any, List, Optional

import numpy as np

from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.analyzer.simulated_analyzer import InProcessAnalyzer
from gpr20_simulator.mid.analyzer.sweeper import SweepPace
from gpr20_simulator.mid.carriage import carriage_position, start_steps
from gpr20_simulator.mid.faults import FaultSwitch
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe, SweptMedium
from gpr20_simulator.mid.world.scene import X_AXIS, Y_AXIS, Z_AXIS, RobotMechanics, Scene
from gpr20_survey.trace.trace import Trace

# A wait for what certainly comes ends here, so that a fault of the test ends it [s].
LIMIT_S = 60.0
# Coarser than the robot's: each step costs the time of this computer.
STEP_MM = 0.1
MECHANICS = RobotMechanics(
    replace(X_AXIS, size_per_step=STEP_MM), replace(Y_AXIS, size_per_step=STEP_MM), Z_AXIS
)


class LaterProbe(PositionProbe):
    """A position probe that was on for long: its numbers of two sweeps differ by little.

    So a point that is measured again agrees with its trace.
    """

    def s21(
        self,
        frequency_hz: np.ndarray,
        position: AntennaPosition,
        sweep_number: int,
        noise_gain: float = 1.0,
    ) -> np.ndarray:
        """Return what a position probe does 5000 sweeps later."""
        return super().s21(frequency_hz, position, sweep_number + 5000, noise_gain)


class World:
    """Carriage, ground and instrument, with their faults, and the disk.

    Args:
        folder: For everything that is stored.
        medium: What the instrument measures: where it is, and the number of the sweep.
        instrument: Fields of the scene's instrument.
    """

    def __init__(
        self, folder: Path, medium: Optional[SweptMedium] = None, **instrument: Any
    ) -> None:
        self.folder, self.data = folder, folder / "data"
        self.acknowledged: List[Trace] = []
        self.free_bytes = 10**12
        self.scene = Scene(robot=MECHANICS)
        self.scene = replace(self.scene, instrument=replace(self.scene.instrument, **instrument))
        self.state = open_shared_state(folder / "state", start_steps(MECHANICS))
        self.vna = InProcessAnalyzer(
            medium or LaterProbe(), self.position, self.scene.instrument, SweepPace().faster(10.0)
        )
        self.time = self.vna.time
        self._switch = FaultSwitch(self.state, self.vna.faults)

    def position(self) -> AntennaPosition:
        """Return where the antennas are."""
        return carriage_position(self.state, MECHANICS)

    def fault(self, *faults: str, device: str = "vna", count: int = 0) -> None:
        """Switch faults of a device on, or with NONE all of them off."""
        for fault in faults:
            self._switch.set(device, fault, count)

    def keep_disk(self) -> None:
        """Let the next robot find the disk as it is now, whatever the present one does to its."""
        kept = self.folder / f"{self.data.name}_"
        if self.data.exists():
            shutil.copytree(str(self.data), str(kept))
        self.data = kept
