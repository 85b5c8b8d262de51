"""Check that no program decides by words: sentences are for people, faults and types for programs.

`scripts/lint.sh` starts it with the names of the source files. It fails on a comparison or a search
in a template, a sentence, the text of a message or of an error, and the values of diagnostics.
"""

from __future__ import annotations

import ast
from typing import Iterator, Optional, Set

from literal_templates import EXCEPT, check_files

# Attributes and variables that hold words for people, or a message with them.
WORDS = frozenset(
    [
        "details",
        "failure",
        "message",
        "message_json",
        "problem",
        "reason",
        "reason_json",
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
    | {"__contains__"}
)
CASES = frozenset({"lower", "upper", "strip", "casefold"})
PATTERNS = frozenset({"match", "search", "fullmatch", "findall", "finditer", "contains"})


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
        # Variables of the present function: words themselves, what holds words, caught errors, and
        # values of diagnostics.
        self._texts: Set[str] = set()
        self._words: Set[str] = set()
        self._errors: Set[str] = set()
        self._values: Set[str] = set()
        self.visit(tree)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        outer = self._texts, self._words, self._errors, self._values
        self._texts, self._words = set(self._texts), set(self._words)
        self._errors, self._values = set(self._errors), set(self._values)
        for one in ast.walk(node):
            self._note_variables(one)
        self.generic_visit(node)
        self._texts, self._words, self._errors, self._values = outer

    def _note_variables(self, node: ast.AST) -> None:
        if isinstance(node, ast.ExceptHandler) and node.name:
            self._errors.add(node.name)
        elif isinstance(node, ast.arg) and _is_message_type(node.annotation):
            self._words.add(node.arg)
        elif isinstance(node, ast.Assign):
            self._note_variable(node.targets[0], node.value)
        elif isinstance(node, ast.NamedExpr):
            self._note_variable(node.target, node.value)
        elif isinstance(node, ast.For) and isinstance(node.target, ast.Tuple):
            items = getattr(node.iter, "func", None)
            if isinstance(items, ast.Attribute) and self._is_diagnostics(items.value):
                self._words.add(_named(node.target.elts[-1]))

    def _note_variable(self, target: ast.AST, value: ast.AST) -> None:
        if not isinstance(target, ast.Name):
            return
        if self._is_text(value):
            self._texts.add(target.id)
        elif _is_diagnostics(value):
            self._values.add(target.id)
        elif self._holds_words(value):
            self._words.add(target.id)

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
            is_table = _named(owner).isupper() or isinstance(owner, ast.Dict)
            looked_up = node.args[:1] if name == "get" and is_table else []
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
            return len(node.values) == 1 and any(self._is_shown(one) for one in shown)
        if not isinstance(node, ast.Call):
            return False
        if isinstance(node.func, ast.Attribute):
            if node.func.attr == "sentence":
                return True
            return node.func.attr in CASES and self._is_text(node.func.value)
        return _named(node.func) in ("str", "repr") and any(map(self._is_shown, node.args[:1]))

    def _is_shown(self, node: ast.AST) -> bool:
        """Return whether the text of an expression is words for people."""
        return _named(node) in WORDS | ERRORS or (
            isinstance(node, ast.Name) and node.id in self._words | self._errors
        )

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
        if isinstance(node, ast.JoinedStr):
            parts = [one.value for one in node.values if isinstance(one, ast.FormattedValue)]
            return any(self._is_shown(one) for one in parts)
        return _named(node) in WORDS or (isinstance(node, ast.Name) and node.id in self._words)

    def _is_diagnostics(self, node: ast.AST) -> bool:
        return _is_diagnostics(node) or (isinstance(node, ast.Name) and node.id in self._values)


def _is_diagnostics(node: ast.AST) -> bool:
    """Return whether an expression is the values of diagnostics; those of a message are not."""
    if isinstance(node, ast.Call) and _named(node.func) == "dict" and node.args:
        node = node.args[0]
    if not isinstance(node, ast.Attribute) or node.attr != "values":
        return False
    return _named(node.value) not in WORDS


def _is_message_type(node: Optional[ast.AST]) -> bool:
    """Return whether an annotation is that of a message, or of one that may be missing."""
    if isinstance(node, ast.Subscript):
        return _named(node.value) == "Optional" and _is_message_type(node.slice)
    return _named(node) == "Message"


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
