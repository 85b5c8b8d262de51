"""Check that no program decides by words: sentences are for people, faults and types for programs.

`scripts/lint.sh` starts it with the names of the source files. It fails on a comparison or a search
in a template, a sentence, the text of a message or of an error, and the values of diagnostics.
"""

from __future__ import annotations

import ast
from typing import Iterator, Set

from literal_templates import EXCEPT, check_files

# Attributes and variables that hold words for people, or a message with them.
WORDS = frozenset(
    [
        "details",
        "failure",
        "message",
        "problem",
        "reason",
        "refusal",
        "remark",
        "sentence",
        "summary",
        "template",
        "verdict",
        "warning",
        "strerror",
    ]
)
# What an error is called where it is caught.
ERRORS = frozenset({"err", "error", "exc", "exception", "failed", "failure", "fault", "refused"})
SEARCHES = frozenset(
    {"startswith", "endswith", "find", "rfind", "index", "count", "partition", "split"}
)
CASES = frozenset({"lower", "upper", "strip", "casefold"})
PATTERNS = frozenset({"match", "search", "fullmatch", "findall", "finditer"})


class _Words(ast.NodeVisitor):
    """Collects the lines of a source file in which words decide."""

    def __init__(self, tree: ast.Module) -> None:
        self.lines: Set[int] = set()
        self._constants = {
            target.id
            for node in tree.body
            if isinstance(node, (ast.Assign, ast.AnnAssign)) and _makes_message(node.value)
            for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
            if isinstance(target, ast.Name)
        }
        # Variables of the present function that hold words, or values of diagnostics.
        self._texts: Set[str] = set()
        self._values: Set[str] = set()
        self.visit(tree)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        outer = self._texts, self._values
        self._texts, self._values = set(self._texts), set(self._values)
        for one in ast.walk(node):
            if isinstance(one, ast.Assign) and isinstance(one.targets[0], ast.Name):
                if self._is_text(one.value):
                    self._texts.add(one.targets[0].id)
                elif _is_diagnostics(one.value):
                    self._values.add(one.targets[0].id)
        self.generic_visit(node)
        self._texts, self._values = outer

    def visit_Compare(self, node: ast.Compare) -> None:
        operands = [node.left, *node.comparators]
        if not any(isinstance(one, ast.Constant) and one.value in (None, "") for one in operands):
            fixed = any(self._is_fixed(one) for one in operands)
            member = any(isinstance(one, (ast.In, ast.NotIn)) for one in node.ops)
            if any(
                self._is_text(one) or (self._holds_words(one) and (fixed or member))
                for one in operands
            ):
                self.lines.add(node.lineno)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        if isinstance(node.func, ast.Attribute):
            name, owner = node.func.attr, node.func.value
            searched = [owner] if name in SEARCHES else node.args if name in PATTERNS else []
            # A table of what is done about which sentence.
            looked_up = node.args[:1] if name == "get" and _named(owner).isupper() else []
            if any(self._holds_words(one) or self._is_text(one) for one in [*searched, *looked_up]):
                self.lines.add(node.lineno)
        self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        is_read = isinstance(node.ctx, ast.Load)
        table = _named(node.value).isupper() and self._holds_words(node.slice)
        if is_read and (table or self._is_text(node.slice)):
            self.lines.add(node.lineno)
        self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        # Only what translates and sends messages needs their templates.
        if node.attr == "template" and _named(node.value) not in ("self", "catalogue"):
            self.lines.add(node.lineno)
        self.generic_visit(node)

    def _is_fixed(self, node: ast.AST) -> bool:
        """Return whether an expression is written out: a text, a message, or a constant of one."""
        if isinstance(node, ast.Constant):
            return isinstance(node.value, str)
        if isinstance(node, (ast.Tuple, ast.Set, ast.List)):
            return any(self._is_fixed(one) for one in node.elts)
        name = _named(node)
        return _makes_message(node) or name in self._constants or name.isupper()

    def _is_text(self, node: ast.AST) -> bool:
        """Return whether an expression is the words of a message or an error themselves."""
        if isinstance(node, ast.Name):
            return node.id in self._texts
        if isinstance(node, ast.Attribute):
            return node.attr == "template"
        if isinstance(node, ast.Subscript):
            return self._is_text(node.value) or _is_arguments(node.value)
        if isinstance(node, ast.JoinedStr):
            shown = [one.value for one in node.values if isinstance(one, ast.FormattedValue)]
            return len(node.values) == 1 and any(_named(one) in WORDS | ERRORS for one in shown)
        if not isinstance(node, ast.Call):
            return False
        if isinstance(node.func, ast.Attribute):
            if node.func.attr == "sentence":
                return True
            return node.func.attr in CASES and self._is_text(node.func.value)
        shown_name = _named(node.args[0]) if node.args else ""
        return _named(node.func) in ("str", "repr") and shown_name in WORDS | ERRORS

    def _holds_words(self, node: ast.AST) -> bool:
        """Return whether an expression is a message, a text for people or one of diagnostics."""
        if isinstance(node, ast.Subscript):
            owner = node.value
            return self._is_diagnostics(owner) or (
                isinstance(node.slice, ast.Slice) and self._holds_words(owner)
            )
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            if node.func.attr in CASES:
                return self._holds_words(node.func.value)
            return node.func.attr == "get" and self._is_diagnostics(node.func.value)
        return _named(node) in WORDS

    def _is_diagnostics(self, node: ast.AST) -> bool:
        return _is_diagnostics(node) or (isinstance(node, ast.Name) and node.id in self._values)


def _is_diagnostics(node: ast.AST) -> bool:
    """Return whether an expression is the values of diagnostics; those of a message are not."""
    if not isinstance(node, ast.Attribute) or node.attr != "values":
        return False
    return _named(node.value) not in WORDS


def _is_arguments(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and node.attr == "args" and _named(node.value) in ERRORS


def _makes_message(node: object) -> bool:
    return isinstance(node, ast.Call) and _named(node.func) in ("Message", "verbatim", "with_fault")


def _named(node: object) -> str:
    return str(getattr(node, "id", getattr(node, "attr", ""))).lstrip("_")


def complaints(source: str) -> Iterator[str]:
    """Yield what is wrong with a source text, each with its line."""
    for line in sorted(_Words(ast.parse(source)).lines):
        yield (
            f"{line}: words for people decide here; use the fault's code, an error's class, or a "
            "typed field"
        )


if __name__ == "__main__":
    check_files(complaints, EXCEPT)
