"""What this package adds to gpr20, as its pyproject.toml says it."""

import ast
import configparser
import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]


def entries():
    """Return the entry points, as in a file entry_points.txt."""
    sections = re.findall(
        r'^\[project\.entry-points\."(.+)"\]\n((?:.+\n)+)',
        (PACKAGE / "pyproject.toml").read_text(),
        re.MULTILINE,
    )
    return "\n".join(f"[{group}]\n{lines}".replace('"', "") for group, lines in sections)


def added():
    """Return the objects by name, by group."""
    parsed = configparser.ConfigParser(delimiters="=")
    parsed.read_string(entries())
    return {group: dict(parsed[group]) for group in parsed.sections()}


def additions_of_catkin():
    """Return the same as setup.py has it."""
    (call,) = (
        node
        for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text()))
        if isinstance(node, ast.keyword) and node.arg == "entry_points"
    )
    return {
        group: dict(line.split(" = ") for line in lines)
        for group, lines in ast.literal_eval(call.value).items()
    }
