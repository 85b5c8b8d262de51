"""What is wrong with this computer, in a fraction of a second, before a real robot starts."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Mapping, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.mid.extension import is_extension
from gpr20_common.mid.node_facts import NO_HARDWARE, NodeSoftware
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import examine
from gpr20_doctor.mid.machine import ROOT, Machine
from gpr20_doctor.mid.node_health import axis_node
from gpr20_launch import faults
from gpr20_launch.mid.launch_request import REAL, ROBOT, LaunchRequest
from gpr20_launch.mid.robot_files import Sections
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import (
    ANALYZER,
    HEIGHT_SENSOR,
    STORAGE,
    NodeDescription,
)
from gpr20_vna_acquisition.mid.analyzer_record import has_passed
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# The part of the configuration that each node gets.
SECTIONS: Mapping[str, str] = {
    **{axis_node(one): f"{one.value}_axis" for one in AxisId},
    HEIGHT_SENSOR: "height_sensor",
    STORAGE: "storage",
    ANALYZER: ANALYZER,
}
# The name of a computer that is not this one.
ANOTHER = "another"


def machine_warnings(
    request: LaunchRequest,
    sections: Sections,
    environment: Mapping[str, str],
    root: Path = ROOT,
) -> Tuple[Finding, ...]:
    """Return what is wrong with this computer; nothing for a simulated robot."""
    if request.robot != REAL:
        return ()
    host, nodes = socket.gethostname(), {}
    for node, section in SECTIONS.items():
        here = NodeSoftware(host=host if node in request.nodes else ANOTHER)
        nodes[node] = NodeDescription(node, NO_HARDWARE, sections.get(section, {}), here)
    machine = Machine.here(environment, root, request.folder, nodes, thorough=False)
    bad = tuple(one for one in examine(machine).found if one.level >= Level.WARNING)
    return bad + _unchecked_analyzer(request, sections)


def _unchecked_analyzer(request: LaunchRequest, sections: Sections) -> Tuple[Finding, ...]:
    """Return a warning of a class for the analyzer that was not checked, or has failed."""
    parameters = record_from(VnaParameters, sections.get(ANALYZER, {}), ANALYZER)
    # Its class is installed where the analyzer's node runs.
    if request.part == ROBOT or not is_extension(parameters.analyzer):
        return ()
    if has_passed(request.folder, parameters):
        return ()
    text = Message(
        "{analyzer} has not passed the check of analyzers as it is now",
        analyzer=parameters.analyzer,
    )
    advice = Message("Before the next survey run: rosrun gpr20_vna_acquisition check_analyzer")
    return (Finding.of("analyzer", text, faults.NOT_CHECKED, mild=True, advice=advice),)
