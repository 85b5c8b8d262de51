"""Check of the entries of a survey's description against each other."""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey.plan.robot_description import is_simulated_identity


def contradictions(description: Dict[str, Any]) -> List[Message]:
    """Return where the entry `simulated` contradicts what measured the survey."""
    simulated = description.get("simulated")
    if not isinstance(simulated, bool):
        return []
    found: List[Message] = []
    identity = _identity(description)
    if identity is not None and is_simulated_identity(identity) is not simulated:
        found.append(
            Message(
                "the survey says simulated: {simulated}, but the analyzer's identity is {identity}",
                simulated=_json(simulated),
                identity=identity,
            )
        )
    for name, node_simulated in _nodes(description):
        if node_simulated is not simulated:
            found.append(
                Message(
                    "the survey says simulated: {simulated}, but for node {node} it says "
                    "{node_simulated}",
                    simulated=_json(simulated),
                    node=name,
                    node_simulated=_json(node_simulated),
                )
            )
    return found


def _identity(description: Dict[str, Any]) -> Optional[str]:
    instrument = description.get("instrument")
    identity = instrument.get("identity") if isinstance(instrument, dict) else None
    return identity if isinstance(identity, str) else None


def _nodes(description: Dict[str, Any]) -> Iterator[Tuple[str, Any]]:
    nodes = description.get("nodes", [])
    for node in nodes if isinstance(nodes, list) else [nodes]:
        values = node if isinstance(node, dict) else {}
        yield str(values.get("name", node)), values.get("simulated")


def _json(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)
