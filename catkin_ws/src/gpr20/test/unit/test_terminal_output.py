"""Programs print texts by `say`, which spells out what would control a terminal."""

from __future__ import annotations

import ast
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[3]
SAFE = frozenset({"json.dumps", "as_json"})
"""They write everything that is not ASCII as an escape of JSON."""
OWN = ("gpr20_common/terminal_text.py",)


def name_of(node: ast.AST) -> str:
    if isinstance(node, ast.Attribute):
        return f"{name_of(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def is_safe(call: ast.Call) -> bool:
    values = call.args
    return all(isinstance(one, ast.Call) and name_of(one.func) in SAFE for one in values)


def writes(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    name = name_of(node.func)
    if name in ("sys.stdout.write", "sys.stderr.write", "traceback.print_stack"):
        return True
    return name == "print" and not is_safe(node)


def test_no_program_prints_a_text_as_it_came():
    found = [
        f"{path.relative_to(SOURCES)}:{node.lineno}"
        for folder in SOURCES.glob("gpr20*")
        for part in ("src", "nodes")
        for path in sorted((folder / part).rglob("*"))
        if path.is_file() and (path.suffix == ".py" or part == "nodes")
        if not str(path).endswith(OWN)
        for text in (path.read_text(encoding="utf-8"),)
        if "print" in text or "sys.std" in text
        for node in ast.walk(ast.parse(text))
        if writes(node)
    ]
    assert not found, f"print by gpr20_common.terminal_text.say: {found}"
