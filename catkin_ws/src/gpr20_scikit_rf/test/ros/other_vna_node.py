#!/usr/bin/env python3
"""The node of the real analyzer, which says of itself that its analyzer is simulated."""

from gpr20_common.high.node import run_device
from gpr20_common.mid.hardware import Hardware
from gpr20_vna_acquisition.high.vna_node import NODE, VNANode, build_vna_node
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# That of the launch.
TIME_SCALE = 100.0


def build(parameters: VnaParameters) -> VNANode:
    hardware = Hardware(f"simulated {parameters.model}", simulated=True, time_scale=TIME_SCALE)
    return build_vna_node(parameters, lambda _address: None, hardware)


run_device(NODE, VnaParameters, build)
