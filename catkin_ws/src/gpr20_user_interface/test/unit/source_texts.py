"""Every text of the source that is translated, found in its syntax."""

import ast
from pathlib import Path
from typing import Iterator, Set, Tuple

import gpr20_user_interface

ROOT = Path(gpr20_user_interface.__file__).resolve().parent


def source_texts(root: Path = ROOT) -> Set[Tuple[str, str]]:
    """Return context and text of every call of tr, translate and QT_TRANSLATE_NOOP."""
    found: Set[Tuple[str, str]] = set()
    for path in sorted(root.rglob("*.py")):
        found.update(_texts_of(ast.parse(path.read_text(encoding="utf-8")), "", path))
    return found


def _texts_of(node: ast.AST, class_name: str, path: Path) -> Iterator[Tuple[str, str]]:
    if isinstance(node, ast.ClassDef):
        class_name = node.name
    if isinstance(node, ast.Call):
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name == "tr":
            yield class_name, _literal(node.args[0], path)
        elif name == "translate" and isinstance(node.args[1], ast.Name):
            pass  # marked where it is written
        elif name in ("translate", "QT_TRANSLATE_NOOP") and len(node.args) >= 2:
            yield _literal(node.args[0], path), _literal(node.args[1], path)
    for child in ast.iter_child_nodes(node):
        yield from _texts_of(child, class_name, path)


def _literal(node: ast.AST, path: Path) -> str:
    # A text that is put together at run time cannot be looked up.
    assert isinstance(node, ast.Constant), f"{path}:{node.lineno}: not a literal text"
    return node.value
