"""Write the pictures of docs/architecture.md from its text, into docs/images.

With --check it fails if a picture is not up to date.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Dict

from graph_picture import graph_picture
from states_picture import states_picture

DOCS = Path(__file__).resolve().parents[2] / "docs"


def pictures() -> Dict[Path, str]:
    """Return the pictures by their files."""
    page = (DOCS / "architecture.md").read_text(encoding="utf-8")
    found = re.search(r"```mermaid\n(.*?)```", page, re.DOTALL)
    if found is None:
        raise ValueError("docs/architecture.md has no diagram of the states")
    return {
        DOCS / "images/graph.svg": graph_picture(page),
        DOCS / "images/states.svg": states_picture(found[1]),
    }


if __name__ == "__main__":
    for path, text in pictures().items():
        if sys.argv[1:] != ["--check"]:
            path.write_text(text, encoding="utf-8")
        elif path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path} is not up to date; run scripts/pictures.sh")
