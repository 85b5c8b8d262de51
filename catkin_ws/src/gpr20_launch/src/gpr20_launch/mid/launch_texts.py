"""What a text of a ROS 1 launch file means: substitutions, expressions and types."""

from __future__ import annotations

import ast
import operator
import re
from pathlib import Path
from typing import Any, Callable, Mapping, Union

from gpr20_common.low.yaml_file import parse_yaml
from gpr20_common.message import Message
from gpr20_launch.errors import OldElementError

LONGEST_EXPRESSION = 500
BOOLS = {"true": True, "1": True, "false": False, "0": False}
# Around the name of a package, whose folder is looked for beside the file that names it.
FOUND = "\0"
_UNUSABLE = (TypeError, ValueError, ArithmeticError, LookupError, SyntaxError, RecursionError)
_SUBSTITUTION = re.compile(r"\$\(\s*(\w+)(?:\s+([^()]*?))?\s*\)")
_OPERATORS: Mapping[type, Callable[..., Any]] = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.UAdd: operator.pos},
    **{ast.Mult: operator.mul, ast.Div: operator.truediv, ast.USub: operator.neg},
}


def unknown(text: str) -> OldElementError:
    """Return the error that names a text which cannot be understood here."""
    return OldElementError(Message("{text} is not known here", text=text))


def substituted(text: str, arguments: Mapping[str, str], file: Path) -> str:
    """Return a text of a file with its args; packages are between `FOUND`.

    Raises:
        OldElementError: Something in it is known only on the original's computer.
    """
    if text.startswith("$(eval ") and text.endswith(")"):
        return _evaluated(text, arguments)

    def value(match: re.Match[str]) -> str:
        kind, rest = match.group(1), match.group(2) or ""
        if kind == "arg" and rest in arguments:
            return arguments[rest]
        if kind == "dirname":
            return str(file.absolute().parent)
        if kind == "find":
            return f"{FOUND}{rest}{FOUND}"
        if kind == "anon":
            return rest
        # Also optenv: only the original's computer knows whether the variable was set.
        raise unknown(match.group(0))

    result = _SUBSTITUTION.sub(value, text)
    if "$(" in result:
        raise unknown(result)
    return result


def _evaluated(text: str, arguments: Mapping[str, str]) -> str:
    """Return the value of an expression of numbers and args."""

    def value(node: ast.AST) -> Any:
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return node.value
        name = node.id if isinstance(node, ast.Name) else None
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "arg":
            (name,) = (getattr(one, "value", None) for one in node.args)
        if isinstance(name, str):
            number = _plain(arguments[name])
            return number if type(number) is float else int(number)
        if isinstance(node, ast.UnaryOp):
            return _OPERATORS[type(node.op)](value(node.operand))
        if isinstance(node, ast.BinOp):
            return _OPERATORS[type(node.op)](value(node.left), value(node.right))
        raise unknown(text)

    if len(text) > LONGEST_EXPRESSION:
        raise unknown(text[:LONGEST_EXPRESSION])
    try:
        return str(value(ast.parse(text[len("$(eval ") : -1].strip(), mode="eval").body))
    except (*_UNUSABLE, MemoryError) as error:
        raise unknown(text) from error


def _plain(text: str) -> Union[int, float, bool, str]:
    """Return a value as roslaunch understands it without a type."""
    try:
        if "." in text:
            return float(text)
        if "_" not in text:
            return int(text)
    except ValueError:
        pass
    return {"true": True, "false": False}.get(text.lower(), text)


_TYPES: Mapping[str, Callable[[str], Any]] = {
    **{"auto": _plain, "str": str, "string": str, "int": int, "double": float},
    **dict.fromkeys(("bool", "boolean"), lambda text: BOOLS[text.lower().strip()]),
    "yaml": lambda text: parse_yaml(text, odd_numbers=True),
}


def typed(text: str, kind: str) -> Any:
    """Return a value of a type, a `type` of `<param>`, as roslaunch understands it.

    Raises:
        OldElementError: It is none of that type.
    """
    try:
        return _TYPES[kind](text)
    except (LookupError, ValueError) as error:
        raise unknown(f"{kind} {text}") from error
