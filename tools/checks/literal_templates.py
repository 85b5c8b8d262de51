"""Check that xgettext finds every template: a literal, and the call not inside an f-string.

Started by scripts/translations.sh with the names of the source files.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import Callable, Iterator, Tuple

FUNCTIONS = ("Message", "tr")
# They pass on a template that was found elsewhere.
EXCEPT = (
    "gpr20_common/message.py",
    "gpr20_common/sent_message.py",
    "gpr20_common/catalogue.py",
)


def templates(tree: ast.AST) -> Iterator[ast.expr]:
    """Yield the first argument of each call that takes a template."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and node.args:
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name in FUNCTIONS:
                yield node.args[0]


def complaints(source: str) -> Iterator[str]:
    """Yield what is wrong with a source text, each with its line."""
    tree = ast.parse(source)
    for template in templates(tree):
        if not (isinstance(template, ast.Constant) and isinstance(template.value, str)):
            yield (
                f"{template.lineno}: write the template as one literal string in Message(...) or "
                "tr(...), with {names} for the values and the values as further arguments"
            )
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and any(templates(node)):
            yield f"{node.lineno}: put the text into a variable of its own, before the f-string"


def check_files(complaints_of: Callable[[str], Iterator[str]], exempt: Tuple[str, ...]) -> None:
    """Check the files that are named, but those whose names end like an exempt one."""
    found = [
        f"{file}:{complaint}"
        for file in sys.argv[1:]
        if not file.endswith(exempt)
        for complaint in complaints_of(Path(file).read_text(encoding="utf-8"))
    ]
    if found:
        sys.exit("\n".join(found))


if __name__ == "__main__":
    check_files(complaints, EXCEPT)
