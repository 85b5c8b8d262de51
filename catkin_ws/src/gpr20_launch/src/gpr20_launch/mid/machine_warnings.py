"""What is wrong with this computer, in a fraction of a second, before a real robot starts."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping, Tuple

from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_facts import HardwareUse
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import MachineRequest
from gpr20_launch.mid.launch_request import REAL, SERVER, LaunchRequest
from gpr20_launch.mid.robot_files import Sections
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import Backend

ROOT = Path("/")


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
    data = sections.get("storage", {}).get("data")
    facts = probe_machine(
        MachineRequest(
            hardware=HardwareUse.ELSEWHERE if elsewhere else HardwareUse.NEEDED,
            environment=environment,
            pin_library=libraries[0] if libraries else "",
            pins=bool(libraries),
            spi=(sensor.get("spi_bus", 0), sensor.get("spi_device", 0)),
            data=Path(str(data)) if data else None,
            thorough=False,
            root=root,
        )
    )
    return tuple(one for one in findings(None, facts) if one.level >= Level.WARNING)
