"""The simulated parts of the robot: what they share, and the drivers' own nodes on them."""

from __future__ import annotations

import hashlib
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import rospy

from gpr20_axis_driver.high.axis_node import AxisNode, build_pin_axis, run_axis
from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.high.node import read_parameters, run_node
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_height_sensor import height_node
from gpr20_height_sensor.height_driver import HeightParameters
from gpr20_simulator.low.shared_state import (
    ScaledClock,
    SharedState,
    open_shared_state,
    remove_stale_states,
)
from gpr20_simulator.mid.carriage import (
    SimulatedHardware,
    carriage_position,
    mechanics_of,
    start_steps,
)
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.range_sensor import RangeSensor, SimulatedSpi
from gpr20_simulator.mid.world.scene import Scene, read_scene
from gpr20_survey.axes import AxisId, AxisParameters
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.high import vna_node
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SHARED_MEMORY = Path("/dev/shm")
LOOPBACK = "127."
# The simulator may still be starting when the first connection is asked for.
PORT_LIMIT_S = 5.0
PORT_POLL_S = 0.02


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


def run_simulated_axis() -> None:
    """Run one axis of the simulated robot; the name of its group, such as x_axis, says which."""
    run_axis(build_simulated_axis)


def build_simulated_axis(axis_id: AxisId, parameters: AxisParameters) -> AxisNode:
    """Build the node of an axis whose pins move the simulated carriage."""
    robot_namespace = rospy.get_namespace().rstrip("/").rsplit("/", 1)[0] + "/"
    part = open_simulated_part(robot_namespace)
    # As on the robot, an axis with an endstop does not know where it is before it is homed.
    first_steps = None if parameters.finds_zero else part.state.steps(axis_id)
    hardware = SimulatedHardware(
        parameters,
        shared_state_path(robot_namespace),
        axis_id,
        mechanics_of(part.scene.robot, axis_id),
        part.clock.factor,
        first_steps,
    )
    return build_pin_axis(axis_id, hardware)


def run_simulated_height() -> None:
    """Run the height sensor of the simulated robot."""
    run_node(
        height_node.NODE,
        lambda: build_simulated_height(read_parameters(HeightParameters, height_node.NODE)),
    )


def build_simulated_height(parameters: HeightParameters) -> height_node.HeightNode:
    """Build the real node over a converter that sees the true height of the antennas."""
    part = open_simulated_part(rospy.get_namespace())
    ground = Ground(part.scene)

    def true_height_m() -> float:
        position = carriage_position(part.state, part.scene.robot)
        return ground.antenna_height_m(position.x_mm, position.y_mm)

    sensor = RangeSensor(part.scene.adc, true_height_m, lambda: part.state.adc_fault)
    return height_node.build_height_node(
        parameters,
        SimulatedSpi(sensor.code),
        part.clock,
        part.hardware("simulated GP2Y0A21YK0F on MCP3008"),
    )


def run_simulated_vna() -> None:
    """Run the VNA driver of the simulated robot."""
    run_node(
        vna_node.NODE, lambda: build_simulated_vna(read_parameters(VnaParameters, vna_node.NODE))
    )


def simulated_port(state: SharedState) -> int:
    """Return the port of the simulated instrument, waiting a bounded time for it to listen.

    Raises:
        VnaConnectionError: It does not listen.
    """
    deadline_s = time.monotonic() + PORT_LIMIT_S
    while state.vna_port == 0 and time.monotonic() < deadline_s:
        time.sleep(PORT_POLL_S)
    if state.vna_port == 0:
        raise VnaConnectionError(
            Message(
                "the simulated VNA does not listen after {limit_s:g} s; check that the simulator "
                "is running",
                limit_s=PORT_LIMIT_S,
            ),
            fault=OTHER_LAUNCH,
        )
    return state.vna_port


def build_simulated_vna(parameters: VnaParameters) -> vna_node.VNANode:
    """Build the real node; only the port of loopback addresses comes from the simulator."""
    part = open_simulated_part(rospy.get_namespace())

    def port_of(address: str) -> Optional[int]:
        if address.startswith(LOOPBACK):
            return simulated_port(part.state)
        return parameters.vxi11_port or None

    return vna_node.build_vna_node(
        parameters, port_of, part.hardware(f"simulated {parameters.model}")
    )
