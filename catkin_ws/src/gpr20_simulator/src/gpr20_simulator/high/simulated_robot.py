"""What every simulated part of the robot needs: the shared state, the scene and the clock."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Tuple

import rospy

from gpr20_simulator.low.scaled_clock import ScaledClock
from gpr20_simulator.low.shared_state import SharedState, open_shared_state
from gpr20_simulator.low.stale_states import remove_stale_states
from gpr20_simulator.mid.carriage import start_steps
from gpr20_simulator.mid.scene import Scene, read_scene

SHARED_MEMORY = Path("/dev/shm")


@dataclass(frozen=True)
class SimulatedPart:
    """The common ground of the processes that simulate one robot.

    Attributes:
        PARAMETERS: Private parameters that such a process has beside its driver's.
        state: What is true of the robot, shared by all of them.
        scene: The machine and the ground.
        clock: Runs as much faster as the robot does.
    """

    PARAMETERS: ClassVar[Tuple[str, ...]] = ("scene", "time_scale")

    state: SharedState
    scene: Scene
    clock: ScaledClock


def open_simulated_part(robot_namespace: str) -> SimulatedPart:
    """Read the parameters `~scene` (a file) and `~time_scale` and open the shared state.

    Args:
        robot_namespace: Namespace in which the robot was launched.

    Raises:
        Gpr20Error: The scene or the time scale is not allowed, or the state cannot be opened.
    """
    scene = read_scene(str(rospy.get_param("~scene", "")))
    clock = ScaledClock(float(rospy.get_param("~time_scale", 1.0)))
    path = shared_state_path(robot_namespace)
    state = open_shared_state(path, start_steps(scene.robot))
    try:
        remove_stale_states(path.parent)
    except OSError as error:
        rospy.logwarn("what former launches left in memory could not be removed: %s", error)
    return SimulatedPart(state, scene, clock)


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
