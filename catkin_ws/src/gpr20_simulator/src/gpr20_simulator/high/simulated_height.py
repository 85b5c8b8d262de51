"""The height sensor on a simulated SPI bus."""

from __future__ import annotations

import rospy

from gpr20_common.high.node import read_parameters, run_node
from gpr20_height_sensor.high.height_node import NODE, HeightNode, build_height_node
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_simulator.high.simulated_robot import open_simulated_part
from gpr20_simulator.mid.carriage import carriage_position
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.range_sensor import RangeSensor, SimulatedSpi


def build_simulated_height(parameters: HeightParameters) -> HeightNode:
    """Build the real node over a converter that sees the true height of the antennas."""
    part = open_simulated_part(rospy.get_namespace())
    ground = Ground(part.scene)

    def true_height_m() -> float:
        position = carriage_position(part.state, part.scene.robot)
        return ground.antenna_height_m(position.x_mm, position.y_mm)

    sensor = RangeSensor(part.scene.adc, true_height_m, lambda: part.state.adc_fault)
    return build_height_node(
        parameters,
        SimulatedSpi(sensor.code),
        part.clock,
        part.hardware("simulated GP2Y0A21YK0F on MCP3008"),
    )


def main() -> None:
    """Run the height sensor of the simulated robot."""
    run_node(NODE, lambda: build_simulated_height(read_parameters(HeightParameters, NODE)))
