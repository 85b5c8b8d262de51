"""Write the pictures of docs/architecture.md and docs/ros.md from their text, into docs/images.

With --check it fails if a picture is not up to date.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Dict

from frames_picture import frames_picture
from graph_picture import graph_picture
from states_picture import states_picture

DOCS = Path(__file__).resolve().parents[2] / "docs"


def pictures() -> Dict[Path, str]:
    """Return the pictures by their files."""
    return {
        DOCS / "images/graph.svg": graph_picture(_page("architecture.md")),
        DOCS / "images/states.svg": states_picture(_diagram("architecture.md")),
        DOCS / "images/frames.svg": frames_picture(_diagram("ros.md")),
    }


def _page(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def _diagram(name: str) -> str:
    found = re.search(r"```mermaid\n(.*?)```", _page(name), re.DOTALL)
    if found is None:
        raise ValueError(f"docs/{name} has no diagram")
    return found[1]


if __name__ == "__main__":
    for path, text in pictures().items():
        if sys.argv[1:] != ["--check"]:
            path.write_text(text, encoding="utf-8")
        elif path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path} is not up to date; run scripts/pictures.sh")
