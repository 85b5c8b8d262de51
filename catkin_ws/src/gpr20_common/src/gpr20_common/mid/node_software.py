"""Which software the parts of a robot run, and whether it is the same."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Mapping, Optional

from gpr20_common import __version__, faults
from gpr20_common.low.revision import git_revision
from gpr20_common.message import Message, in_a_row


@dataclass(frozen=True)
class NodeSoftware:
    """Which software a node runs, and where; what is not known is empty.

    Attributes:
        version: Version of the suite.
        revision: Revision of its sources.
        host: Name of its computer.
    """

    version: str = ""
    revision: str = ""
    host: str = ""

    @property
    def name(self) -> str:
        """Version and revision in one text."""
        return f"{self.version} ({self.revision})" if self.revision else self.version


UNKNOWN_SOFTWARE = NodeSoftware()


def own_software() -> NodeSoftware:
    """Return the software that is installed on this computer."""
    revision = git_revision(Path(__file__).resolve().parent)
    return NodeSoftware(__version__, revision, socket.gethostname())


def software_difference(nodes: Mapping[str, NodeSoftware]) -> Optional[Message]:
    """Return which nodes run which software; None if all run the same.

    Args:
        nodes: The software of each node. Nodes that do not say theirs are not compared.
    """
    groups: Dict[str, List[str]] = {}
    for node, software in nodes.items():
        if software.version:
            groups.setdefault(software.name, []).append(node)
    if len(groups) < 2:
        return None
    return Message(
        "the parts of the robot run different software: {groups}",
        groups=in_a_row(
            Message(
                "{software} on {hosts}",
                software=name,
                hosts=", ".join(sorted({nodes[node].host or "?" for node in group})),
                details=f"{name}: {', '.join(sorted(group))}",
            )
            for name, group in sorted(groups.items())
        ),
    ).with_fault(faults.SOFTWARE_DIFFERS)
