"""What is wrong with this computer, in a fraction of a second, before a real robot starts."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.extension import is_extension
from gpr20_common.mid.records import record_from
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_facts import HardwareUse
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import MachineRequest
from gpr20_doctor.mid.place import place_of
from gpr20_launch import faults
from gpr20_launch.mid.launch_request import REAL, ROBOT, SERVER, LaunchRequest
from gpr20_launch.mid.robot_files import Sections
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import Backend
from gpr20_vna_acquisition.mid.conformance.record import has_passed
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

ROOT = Path("/")
ANALYZER = "vna_acquisition"


def machine_warnings(
    request: LaunchRequest,
    sections: Sections,
    environment: Mapping[str, str],
    root: Path = ROOT,
) -> Tuple[Finding, ...]:
    """Return what is wrong with this computer; nothing for a simulated robot.

    Args:
        request: The arguments of the launch.
        sections: The configuration of the nodes.
        environment: The environment variables.
        root: Root of the file system.
    """
    if request.robot != REAL:
        return ()
    elsewhere = request.part == SERVER
    axes = [sections.get(f"{one.value}_axis", {}) for one in AxisId]
    with_pins = [one for one in axes if not one.get("controller")]
    libraries = [str(one.get("backend", Backend.RPI_GPIO.value)) for one in with_pins]
    sensor = sections.get("height_sensor", {})
    storage = sections.get("storage", {})
    data = storage.get("data")
    facts = probe_machine(
        MachineRequest(
            hardware=HardwareUse.ELSEWHERE if elsewhere else HardwareUse.NEEDED,
            environment=environment,
            pin_library=libraries[0] if libraries else "",
            pins=bool(libraries),
            spi=(sensor.get("spi_bus", 0), sensor.get("spi_device", 0)),
            data=Path(str(data)) if data else None,
            data_disk=storage.get("data_disk") is True,
            thorough=False,
            root=root,
            place=place_of(environment, root, request.folder)[0],
        )
    )
    bad = tuple(one for one in findings(None, facts) if one.level >= Level.WARNING)
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
    return (Finding.of_fault("analyzer", text.with_fault(faults.UNCHECKED_ANALYZER)),)
