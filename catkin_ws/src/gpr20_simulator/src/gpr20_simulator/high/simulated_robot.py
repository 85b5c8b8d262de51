"""What every simulated part of the robot needs: the shared state, the scene and the clock."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import rospy

from gpr20_common.high.node import read_parameters
from gpr20_common.mid.node_facts import Hardware
from gpr20_simulator.low.scaled_clock import ScaledClock
from gpr20_simulator.low.shared_state import (
    SharedState,
    open_shared_state,
    remove_stale_states,
)
from gpr20_simulator.mid.carriage import start_steps
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_simulator.mid.world.scene import Scene, read_scene

SHARED_MEMORY = Path("/dev/shm")


@dataclass(frozen=True)
class SimulatedPart:
    """The common ground of the processes that simulate one robot.

    Attributes:
        parameters: Parameters of the simulated robot.
        state: What is true of the robot, shared by all of them.
        scene: The machine and the ground.
        clock: Runs as much faster as the robot does.
    """

    parameters: SimulatorParameters
    state: SharedState
    scene: Scene
    clock: ScaledClock

    def hardware(self, name: str) -> Hardware:
        """Return the description of simulated hardware."""
        return Hardware(name, simulated=True, time_scale=self.clock.factor)


def open_simulated_part(robot_namespace: str) -> SimulatedPart:
    """Read the parameters of the simulated robot and open the shared state.

    Args:
        robot_namespace: Namespace in which the robot was launched.

    Raises:
        Gpr20Error: A parameter is not allowed, or the state cannot be opened.
    """
    parameters = read_parameters(SimulatorParameters, "simulator")
    scene = read_scene(parameters.scene)
    clock = ScaledClock(parameters.time_scale)
    path = shared_state_path(robot_namespace)
    state = open_shared_state(path, start_steps(scene.robot))
    try:
        remove_stale_states(path.parent)
    except OSError as error:
        rospy.logwarn("what former launches left in memory could not be removed: %s", error)
    return SimulatedPart(parameters, state, scene, clock)


def shared_state_path(robot_namespace: str) -> Path:
    """Return the file of the shared state of one robot under this ROS master.

    Every process of the robot finds the same file without asking another one, a
    restarted process finds it again, and the next launch gets a fresh state.

    Args:
        robot_namespace: Namespace in which the robot was launched, "/" or "/robot1".
    """
    run_id = str(rospy.get_param("/run_id"))
    name = hashlib.sha256(f"{run_id} {robot_namespace.rstrip('/')}".encode()).hexdigest()[:32]
    # A folder for each user: nobody can be kept out, or let in, by another one.
    return SHARED_MEMORY / f"gpr20-{os.getuid()}" / name
