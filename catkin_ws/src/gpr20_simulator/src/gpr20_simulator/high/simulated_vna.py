"""The VNA driver, finding the simulated instrument behind loopback addresses."""

from __future__ import annotations

import time
from typing import Optional

import rospy

from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.high.node import read_parameters, run_node
from gpr20_common.message import Message
from gpr20_simulator.high.simulated_robot import open_simulated_part
from gpr20_simulator.low.shared_state import SharedState
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.high.vna_node import NODE, VNANode, build_vna_node
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

LOOPBACK = "127."
# The simulator may still be starting when the first connection is asked for.
PORT_LIMIT_S = 5.0
PORT_POLL_S = 0.02


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


def build_simulated_vna(parameters: VnaParameters) -> VNANode:
    """Build the real node; only the port of loopback addresses comes from the simulator."""
    part = open_simulated_part(rospy.get_namespace())

    def port_of(address: str) -> Optional[int]:
        if address.startswith(LOOPBACK):
            return simulated_port(part.state)
        return parameters.vxi11_port or None

    return build_vna_node(parameters, port_of, part.hardware(f"simulated {parameters.model}"))


def main() -> None:
    """Run the VNA driver of the simulated robot."""
    run_node(NODE, lambda: build_simulated_vna(read_parameters(VnaParameters, NODE)))
