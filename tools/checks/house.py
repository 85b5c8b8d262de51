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
from typing import Dict

import tomllib

ROOT = Path(__file__).resolve().parents[2]
COUNTED = {
    *(".action", ".css", ".html", ".js", ".launch", ".msg", ".py"),
    *(".qss", ".sh", ".srv", ".test"),
}


def lines_by_part() -> Dict[str, int]:
    """Return the number of lines of each part of the checkout."""
    command = ["git", "-C", str(ROOT), "ls-files"]
    lines: Counter[str] = Counter()
    for path in map(Path, subprocess.check_output(command, text=True).splitlines()):
        file = ROOT / path
        is_program = path.parent.name == "nodes" and not path.suffix
        if (path.suffix in COUNTED or is_program) and file.is_file() and not file.is_symlink():
            is_package = path.parts[:2] == ("catkin_ws", "src")
            part = path.parts[2] if is_package else path.parts[0]
            is_test = "test" in path.parts[:-1]
            lines[f"{part} tests" if is_test else part] += file.read_bytes().count(b"\n")
    return lines


def limits() -> Dict[str, int]:
    """Return the most lines that each part may have."""
    content = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return dict(content["tool"]["house"]["limits"])


if __name__ == "__main__":
    found, allowed = lines_by_part(), limits()
    for name in sorted(found.keys() | allowed.keys(), key=lambda one: -found.get(one, 0)):
        print(f"{name:28}{found.get(name, 0):7}{allowed.get(name, 0):8}")
    sys.exit(any(number > allowed.get(name, 0) for name, number in found.items()))
