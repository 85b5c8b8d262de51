"""Check of survey.json against its copies, its own entries and the clock."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.description_copies import sealed_description
from gpr20_survey.folder.description_differences import differences
from gpr20_survey.plan.robot_description import is_simulated_identity


def compare_copy(folder: Path, description: Dict[str, Any]) -> List[Message]:
    """Return the differences between survey.json and its copy in the MCAP.

    Args:
        folder: The survey's folder.
        description: The content of survey.json.
    """
    sealed = sealed_description(folder)
    return [] if sealed is None else _differences(description, sealed, survey_folder.MCAP_FILE)


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
                "survey.json says simulated: {simulated}, but the analyzer's identity is "
                "{identity}",
                simulated=_json(simulated),
                identity=identity,
            )
        )
    for name, node_simulated in _nodes(description):
        if node_simulated is not simulated:
            found.append(
                Message(
                    "survey.json says simulated: {simulated}, but for node {node} it says "
                    "{node_simulated}",
                    simulated=_json(simulated),
                    node=name,
                    node_simulated=_json(node_simulated),
                )
            )
    return found


def _differences(description: Dict[str, Any], copy: Dict[str, Any], name: str) -> List[Message]:
    return [
        Message(
            "survey.json has {key} {value}, but its copy in {file} from the start of the survey "
            "has {copy}",
            key=one.key,
            value=one.first,
            file=name,
            copy=one.second,
        )
        for one in differences(description, copy)
    ]


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
