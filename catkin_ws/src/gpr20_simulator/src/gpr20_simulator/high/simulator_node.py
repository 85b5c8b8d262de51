"""The node of the simulated network analyzer and of the simulated robot's faults."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rospy

from gpr20_common.high.diagnostics import ERROR, OK, WARN, Diagnostics, Health
from gpr20_common.high.graph_message import message_fields
from gpr20_common.high.node import run_node
from gpr20_common.high.parameters import read_parameters
from gpr20_common.high.services import advertise
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_simulator.errors import SimulatorError
from gpr20_simulator.high.simulated_robot import SimulatedPart, open_simulated_part
from gpr20_simulator.low.capture import CaptureFolder
from gpr20_simulator.low.portmapper import PORT as PORTMAPPER_PORT
from gpr20_simulator.mid.carriage import carriage_position
from gpr20_simulator.mid.faults import FaultSwitch
from gpr20_simulator.mid.instrument import Capture
from gpr20_simulator.mid.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_simulator.srv import SetFault, SetFaultResponse


@dataclass(frozen=True)
class SimulatorParameters:
    """Private parameters beside `scene` and `time_scale`.

    Attributes:
        seconds_per_point: Time that one frequency of a sweep takes [s].
        port: TCP port of the VXI-11 core channel; 0: any free one.
        portmapper: Whether to answer on port 111 too, where VXI-11 clients look first.
        medium: `scene`, or `position_probe` for tests.
        capture_dir: Folder for the exact bytes of each data reply; empty: none.
    """

    seconds_per_point: float = 350e-6
    port: int = 0
    portmapper: bool = False
    medium: str = "scene"
    capture_dir: str = ""


class SimulatorNode:
    """Serves the simulated analyzer, and switches faults on request."""

    def __init__(
        self, part: SimulatedPart, parameters: SimulatorParameters, vna: SimulatedAnalyzer
    ) -> None:
        self._part = part
        self._parameters = parameters
        self._vna = vna
        self._switch = FaultSwitch(part.state, vna.faults)
        vna.start()
        # The other processes of the robot wait for this before they connect.
        part.state.vna_port = vna.server.port
        rospy.on_shutdown(self._stop)
        advertise("simulator/set_fault", SetFault, self._set_fault)
        self._diagnostics = Diagnostics("SIMULATED robot", self._health)

    def _set_fault(self, request: Any) -> SetFaultResponse:
        message = self._switch.set(request.device, request.fault, request.count)
        rospy.logwarn("%s", message)
        return SetFaultResponse(success=True, **message_fields(message))

    def _health(self) -> Health:
        sweeper, faults = self._vna.sweeper, self._switch.names()
        values = {
            "simulated": True,
            "scene": self._part.scene.name,
            "medium": self._parameters.medium,
            "vna_port": self._vna.server.port,
            "vna_links": self._vna.server.link_count,
            "sweep_number": sweeper.sweep_number,
            "sweeps_completed": sweeper.sweeps_completed,
            "faults": faults or "none",
        }
        if self._vna.instrument.network_lost:
            lost = Message("The SIMULATED VNA was reset and lost its network settings")
            return ERROR, lost, values
        if faults:
            return WARN, Message("The SIMULATED robot has faults: {faults}", faults=faults), values
        return OK, Message("The SIMULATED robot works"), values

    def _stop(self) -> None:
        self._part.state.vna_port = 0
        self._vna.stop()


def main() -> None:
    """Run the simulated analyzer until ROS shuts down."""
    run_node("simulator", build_simulator)


def build_simulator() -> SimulatorNode:
    """Read the parameters and put the node together."""
    parameters = read_parameters(SimulatorParameters, others=SimulatedPart.PARAMETERS)
    part = open_simulated_part(rospy.get_namespace())
    options = AnalyzerOptions(
        parameters.seconds_per_point,
        part.clock.factor,
        parameters.port,
        PORTMAPPER_PORT if parameters.portmapper else None,
    )
    vna = SimulatedAnalyzer(
        medium_by_name(parameters.medium, part.scene),
        lambda: carriage_position(part.state, part.scene.robot),
        part.clock,
        part.scene.instrument,
        options,
        _capture(parameters.capture_dir),
    )
    return SimulatorNode(part, parameters, vna)


def _capture(folder: str) -> Capture:
    if not folder:
        return lambda _kind, _reply: None
    try:
        return CaptureFolder(Path(folder).expanduser()).save
    except OSError as error:
        raise SimulatorError(
            Message(
                "capture_dir {folder} cannot be used: {reason}; give a folder that can be created",
                folder=folder,
                reason=os_reason(error),
            )
        ) from error
