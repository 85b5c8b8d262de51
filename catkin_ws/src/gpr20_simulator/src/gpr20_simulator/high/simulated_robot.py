"""What every simulated part of the robot needs: the world, the scene and the clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Tuple

import rospy

from gpr20_simulator.high.world_path import world_path
from gpr20_simulator.low.old_worlds import remove_old_worlds
from gpr20_simulator.low.scaled_clock import ScaledClock
from gpr20_simulator.low.world import World, open_world
from gpr20_simulator.mid.carriage import start_steps
from gpr20_simulator.mid.scene import Scene, read_scene


@dataclass(frozen=True)
class SimulatedPart:
    """The common ground of the processes that simulate one robot.

    Attributes:
        PARAMETERS: Private parameters that such a process has beside its driver's.
        world: The truth, shared by all of them.
        scene: The machine and the ground.
        clock: Runs as much faster as the robot does.
    """

    PARAMETERS: ClassVar[Tuple[str, ...]] = ("scene", "time_scale")

    world: World
    scene: Scene
    clock: ScaledClock


def open_simulated_part(robot_namespace: str) -> SimulatedPart:
    """Read the parameters `~scene` (a file) and `~time_scale` and open the world.

    Args:
        robot_namespace: Namespace in which the robot was launched.

    Raises:
        Gpr20Error: The scene or the time scale is not allowed, or the world cannot be opened.
    """
    scene = read_scene(str(rospy.get_param("~scene", "")))
    clock = ScaledClock(float(rospy.get_param("~time_scale", 1.0)))
    path = world_path(robot_namespace)
    world = open_world(path, start_steps(scene.robot))
    try:
        remove_old_worlds(path.parent)
    except OSError as error:
        rospy.logwarn("worlds of former launches could not be cleared away: %s", error)
    return SimulatedPart(world, scene, clock)
