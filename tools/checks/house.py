"""How many lines each part of the project has, against the limits in pyproject.toml.

Usage: .venv/bin/python tools/checks/house.py

A part is a package, or a folder of the checkout; its tests are a part of their own. All lines of
programs and interfaces count, also empty ones and comments. Who makes a part smaller lowers its
limit, to the next hundred.
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Dict, List

import tomllib

ROOT = Path(__file__).resolve().parents[2]
COUNTED = {
    *(".action", ".css", ".html", ".js", ".launch", ".msg", ".py"),
    *(".qss", ".sh", ".srv", ".test"),
}
STEP = 100


def part_of(name: str) -> str:
    """Return the part that a file belongs to; empty: it is not counted.

    Args:
        name: Path in the checkout.
    """
    path = Path(name)
    is_program = path.parent.name == "nodes" and not path.suffix
    if path.suffix not in COUNTED and not is_program:
        return ""
    is_package = path.parts[:2] == ("catkin_ws", "src")
    part = path.parts[2] if is_package else path.parts[0]
    return f"{part} tests" if "test" in path.parts[:-1] else part


def lines_by_part(root: Path) -> Dict[str, int]:
    """Return the number of lines of each part of a checkout."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=str(root), stdout=subprocess.PIPE, text=True, check=True
    ).stdout.splitlines()
    lines: Counter = Counter()
    for name in listed:
        path, part = root / name, part_of(name)
        if part and path.is_file() and not path.is_symlink():
            lines[part] += path.read_bytes().count(b"\n")
    return dict(lines)


def limits(root: Path) -> Dict[str, int]:
    """Return the most lines that each part may have."""
    content = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    return dict(content["tool"]["house"]["limits"])


def complaints(lines: Dict[str, int], allowed: Dict[str, int]) -> List[str]:
    """Return what is wrong: parts that are too large, without a limit, or no longer there."""
    found = []
    for part, number in sorted(lines.items()):
        if part not in allowed:
            found.append(f"{part} has {number} lines and no limit in pyproject.toml")
        elif number > allowed[part]:
            found.append(f"{part} has {number} lines; at most {allowed[part]} are allowed")
    gone = sorted(set(allowed) - set(lines))
    return found + [f"{part} has a limit in pyproject.toml and no lines" for part in gone]


def main() -> int:
    """Print a line for each part; return 1 if one has too many."""
    lines, allowed = lines_by_part(ROOT), limits(ROOT)
    for part, number in sorted(lines.items(), key=lambda one: -one[1]):
        least = -(-number // STEP) * STEP
        lower = f"  can be {least}" if least < allowed.get(part, 0) else ""
        print(f"{part:28}{number:7}{allowed.get(part, '-'):>8}{lower}")
    found = complaints(lines, allowed)
    print("\n".join(found) or "no part is larger than its limit")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
