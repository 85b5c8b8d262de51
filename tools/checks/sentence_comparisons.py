"""Check that no program compares a sentence: people read it, programs decide by a fault's code.

`scripts/lint.sh` starts it with the names of the source files.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import Iterator, List

# What words for people are called, and the errors whose text is such words.
WORDS = {"details", "failure", "message", "problem", "reason", "refusal", "remark"}
WORDS |= {"sentence", "strerror", "summary", "template", "verdict", "warning"}
ERRORS = {"err", "error", "exc", "exception", "failed", "fault", "refused"}
SEARCHES = {"startswith", "endswith", "find", "index", "count", "partition", "split"}
PATTERNS = {"match", "search", "fullmatch", "findall", "finditer"}


def _named(node: ast.AST) -> str:
    return str(getattr(node, "id", getattr(node, "attr", ""))).lstrip("_")


def _is_words(node: ast.AST) -> bool:
    if isinstance(node, ast.Subscript):
        return _is_words(node.value)
    if isinstance(node, ast.Call) and _named(node.func) in ("str", "repr"):
        return any(_named(one) in WORDS | ERRORS for one in node.args)
    if isinstance(node, ast.Call) and _named(node.func) in ("lower", "strip"):
        return _is_words(getattr(node.func, "value", node.func))
    if isinstance(node, ast.Call):
        return _named(node.func) == "sentence"
    if isinstance(node, ast.JoinedStr):
        return any(_named(getattr(one, "value", one)) in WORDS | ERRORS for one in node.values)
    return _named(node) in WORDS


def complaints(source: str) -> Iterator[int]:
    """Yield the lines of a source text in which words decide."""
    for node in ast.walk(ast.parse(source)):
        compared: List[ast.expr] = []
        if isinstance(node, ast.Compare):
            compared = [node.left, *node.comparators]
            # Two messages may be compared: whether another one is shown than before.
            if all(_named(one) and not _named(one).isupper() for one in compared) or any(
                isinstance(one, ast.Constant) and not one.value for one in compared
            ):
                continue
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            name = node.func.attr
            compared = [node.func.value] if name in SEARCHES else []
            compared += node.args if name in PATTERNS else []
        if any(map(_is_words, compared)):
            yield compared[0].lineno


if __name__ == "__main__":
    lines = [f"{one}:{line}" for one in sys.argv[1:] for line in complaints(Path(one).read_text())]
    sys.exit("\n".join([*lines, "words decide there: use the fault's code"]) if lines else 0)
