"""Pictures of architecture.md, ros.md and reference/ros_graph.md, from their text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Dict

from pictures.frames import frames_picture
from pictures.graph import graph_picture
from pictures.states import states_picture

DOCS = Path(__file__).resolve().parents[2] / "docs"


def make(folder: Path) -> None:
    """Write the pictures."""
    for name, text in pictures().items():
        (folder / name).write_text(text, encoding="utf-8")
        print(folder / name)


def pictures() -> Dict[str, str]:
    """Return the pictures by the names of their files."""
    return {
        "graph.svg": graph_picture(_page("reference/ros_graph.md")),
        "states.svg": states_picture(_diagram("architecture.md")),
        "frames.svg": frames_picture(_diagram("ros.md")),
    }


def _page(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def _diagram(name: str) -> str:
    found = re.search(r"```mermaid\n(.*?)```", _page(name), re.DOTALL)
    if found is None:
        raise ValueError(f"docs/{name} has no diagram")
    return found[1]
