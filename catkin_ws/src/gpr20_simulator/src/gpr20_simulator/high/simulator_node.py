"""The node of the simulated network analyzer and of the simulated robot's faults."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import rospy

from gpr20_common.errors import os_reason
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.node import publish_description, run_node
from gpr20_common.message import Message
from gpr20_simulator.high.simulated_robot import SimulatedPart, open_simulated_part
from gpr20_simulator.low.vxi11_server import PORTMAPPER_PORT
from gpr20_simulator.mid.analyzer.instrument import Capture
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_simulator.mid.carriage import carriage_position
from gpr20_simulator.mid.faults import FAULTS_SET, FaultSwitch, SimulatorError
from gpr20_simulator.srv import SetFault, SetFaultResponse

NODE = "simulator"
HARDWARE = "SIMULATED robot"


class SimulatorNode:
    """Serves the simulated analyzer, and switches faults on request."""

    def __init__(self, part: SimulatedPart, vna: SimulatedAnalyzer) -> None:
        self._part = part
        self._vna = vna
        self._switch = FaultSwitch(part.state, vna.faults)
        vna.start()
        # The other processes of the robot wait for this before they connect.
        part.state.vna_port = vna.server.port
        rospy.on_shutdown(self._stop)
        advertise("simulator/set_fault", SetFault, self._set_fault)
        self._diagnostics = Diagnostics(HARDWARE, self._health)
        self._description = publish_description(NODE, part.hardware(HARDWARE), part.parameters)

    def _set_fault(self, request: Any) -> SetFaultResponse:
        message = self._switch.set(request.device, request.fault, request.count)
        rospy.logwarn("%s", message)
        return SetFaultResponse(success=True, **message_fields(message))

    def _health(self) -> Health:
        sweeper, faults = self._vna.sweeper, self._switch.names()
        values = {
            "simulated": True,
            "scene": self._part.scene.name,
            "medium": self._part.parameters.medium,
            "vna_port": self._vna.server.port,
            "vna_links": self._vna.server.link_count,
            "vna_is_remote": self._vna.instrument.is_remote,
            "vna_is_continuous": sweeper.runs_continuously,
            "sweep_number": sweeper.sweep_number,
            "sweeps_completed": sweeper.sweeps_completed,
            "faults": faults or "none",
        }
        if faults:
            text = Message("The SIMULATED robot has faults: {faults}", faults=faults)
            return WARN, text.with_fault(FAULTS_SET), values
        return OK, Message("The SIMULATED robot works"), values

    def _stop(self) -> None:
        self._part.state.vna_port = 0
        self._vna.stop()


def main() -> None:
    """Run the simulated analyzer until ROS shuts down."""
    run_node(NODE, build_simulator)


def build_simulator() -> SimulatorNode:
    """Read the parameters and put the node together."""
    part = open_simulated_part(rospy.get_namespace())
    parameters = part.parameters
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
    return SimulatorNode(part, vna)


def _capture(folder: str) -> Capture:
    """Return what writes each data reply to a file of its own, such as `000001_sdat.bin`."""
    if not folder:
        return lambda _kind, _reply: None
    place = Path(folder).expanduser()
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SimulatorError(
            Message(
                "capture_dir {folder} cannot be used: {reason}; give a folder that can be created",
                folder=folder,
                reason=os_reason(error),
            )
        ) from error
    used = [int(one.name[:6]) for one in place.glob("[0-9]" * 6 + "_*.bin")]
    numbers = itertools.count(max(used, default=0) + 1)

    def save(kind: str, reply: bytes) -> None:
        with (place / f"{next(numbers):06d}_{kind}.bin").open("xb") as file:
            file.write(reply)

    return save
