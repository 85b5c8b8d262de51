"""Whether all parts of a robot run the same software."""

from __future__ import annotations

from typing import Iterator

from gpr20_common.faults import SOFTWARE_DIFFERS
from gpr20_common.message import Message
from gpr20_common.mid.node_software import NodeSoftware, software_difference
from gpr20_common.remedies import SAME_VERSION
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.node_health import EXPECTED_NODES, IMAGING, MAIN_CONTROL
from gpr20_doctor.mid.robot_facts import RobotFacts
from gpr20_doctor.mid.titles import node_title


def check_versions(facts: RobotFacts) -> Iterator[Finding]:
    """Compare the software of the nodes."""
    if not facts.control_alive:
        return
    silent = next((node for node, one in facts.software.items() if not one.version), None)
    difference = software_difference(facts.software)
    silenced = [one.name for one in facts.nodes if _is_missing(one.name, facts)]
    if not facts.software:
        yield Finding(
            "versions",
            Level.UNKNOWN,
            Message("The software of the parts is not known yet."),
            Message("Wait until all parts of the robot have started."),
        )
    elif difference is not None:
        text = Message("Versions: {difference}", difference=difference)
        yield Finding.of_fault("versions", text)
    elif silent is not None:
        text = Message("{part} does not say which software it runs.", part=node_title(silent))
        yield Finding("versions", Level.UNKNOWN, text, SAME_VERSION)
    elif silenced:
        text = Message("Not known: the software of {parts}", parts=tuple(map(node_title, silenced)))
        yield Finding("versions", Level.UNKNOWN, text, SAME_VERSION)
    else:
        name = next(iter(facts.software.values())).name
        text = Message("Software {software} on every part", software=name)
        yield Finding("versions", Level.OK, text)


def _is_missing(node: str, facts: RobotFacts) -> bool:
    # The node of the images does not describe itself.
    return node in EXPECTED_NODES and node != IMAGING and node not in facts.software


def check_installed(facts: RobotFacts, installed: NodeSoftware) -> Iterator[Finding]:
    """Compare the software of this computer with that of the main control, which runs."""
    running = facts.software.get(MAIN_CONTROL)
    if running is None or not running.version or running.name == installed.name:
        return
    text = Message(
        "The robot runs the software {running}, but {installed} is installed here.",
        running=running.name,
        installed=installed.name,
    )
    yield Finding.of_fault("installed", text.with_fault(SOFTWARE_DIFFERS))
