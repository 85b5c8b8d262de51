"""Check of the entries of a survey's description against each other."""

from __future__ import annotations

from typing import Any, Dict, Iterator

from gpr20_common.message import Message
from gpr20_survey.plan.robot_description import is_simulated_identity


def contradictions(description: Dict[str, Any]) -> Iterator[Message]:
    """Yield where the entry `simulated` contradicts what measured the survey."""
    simulated = description.get("simulated")
    if not isinstance(simulated, bool):
        return
    instrument = description.get("instrument")
    identity = instrument.get("identity") if isinstance(instrument, dict) else None
    if isinstance(identity, str) and is_simulated_identity(identity) is not simulated:
        yield Message(
            "the survey says simulated: {simulated}, but the analyzer's identity is {identity}",
            simulated=_json(simulated),
            identity=identity,
        )
    nodes = description.get("nodes", [])
    for node in nodes if isinstance(nodes, list) else [nodes]:
        values = node if isinstance(node, dict) else {}
        if values.get("simulated") is not simulated:
            yield Message(
                "the survey says simulated: {simulated}, but for node {node} it says "
                "{node_simulated}",
                simulated=_json(simulated),
                node=str(values.get("name", node)),
                node_simulated=_json(values.get("simulated")),
            )


def _json(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)
