"""The faults of the project, where they are reported, and by which sentences.

Errors, faults and sentences are found in the sources, so that nothing has to be imported that
needs ROS or Qt; the faults themselves are those of each package's module `faults`.
"""

from __future__ import annotations

import ast
import importlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, Iterator, List, Optional, Set, Tuple

from gpr20_common.message import Fault

SOURCES = Path(__file__).resolve().parents[2] / "catkin_ws/src"
ROOT_ERROR = "Gpr20Error"
# Keywords that name the fault of an error or a message.
FAULT_KEYWORD, FAULT_METHOD = "fault", "with_fault"


@dataclass(frozen=True)
class ErrorClass:
    """A subclass of Gpr20Error.

    Attributes:
        name: Its name, which is unique in the project.
        base: That of the error it derives from.
        path: Where it stands, below `SOURCES`.
        fault: Name of the fault in its body; empty if it has none of its own.
        used: Whether it is raised or made somewhere.
    """

    name: str
    base: str
    path: str
    fault: str
    used: bool


@dataclass
class FaultTable:
    """All faults by code.

    Attributes:
        faults: The fault of each code.
        names: The code of each constant: `gpr20_survey.DISK_FULL`.
        twice: Codes that two constants have.
        errors: Every error class.
        reported: Codes that are reported somewhere.
        sentences: The templates that report each code, in the order of the sources.
    """

    faults: Dict[str, Fault] = field(default_factory=dict)
    names: Dict[str, str] = field(default_factory=dict)
    twice: List[str] = field(default_factory=list)
    errors: Dict[str, ErrorClass] = field(default_factory=dict)
    reported: Set[str] = field(default_factory=set)
    sentences: Dict[str, List[str]] = field(default_factory=dict)

    def code_of(self, error: str) -> str:
        """Return the code of an error class, of its own or of its base; empty if unknown."""
        while error in self.errors:
            if self.errors[error].fault:
                return self.errors[error].fault
            error = self.errors[error].base
        return "robot.internal_error"

    def codes_of(self, template: str) -> List[str]:
        """Return the codes that a sentence reports."""
        return [code for code, templates in self.sentences.items() if template in templates]


def fault_table() -> FaultTable:
    """Read the sources."""
    table = FaultTable()
    modules = [_Module(path) for path in sorted(SOURCES.glob("gpr20_*/src/**/*.py"))]
    modules += [_Module(path) for path in sorted(SOURCES.glob("gpr20_*/nodes/*")) if path.is_file()]
    for module in modules:
        if module.holds_faults:
            _add_faults(table, module)
    _add_errors(table, modules)
    for module in modules:
        if not module.holds_faults:
            _add_reports(table, module)
    return table


class _Module:
    """A source file, and what the names of faults in it mean."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.package = path.relative_to(SOURCES).parts[0]
        # The simulator has a module of this name for what it simulates.
        self.holds_faults = path.name == "faults.py" and path.parent.name == self.package
        self.tree = ast.parse(path.read_text("utf-8"))
        self._modules: Dict[str, str] = {}
        self._constants: Dict[str, str] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                for name in node.names:
                    known = name.asname or name.name
                    if name.name == "faults":
                        self._modules[known] = node.module
                    elif node.module.endswith(".faults"):
                        owner = node.module[: -len(".faults")]
                        self._constants[known] = f"{owner}.{name.name}"

    def constant(self, node: Optional[ast.AST]) -> str:
        """Return the full name of the fault that an expression names; empty if it is none."""
        if isinstance(node, ast.Name):
            return self._constants.get(node.id, "")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = self._modules.get(node.value.id)
            return f"{owner}.{node.attr}" if owner else ""
        return ""


def _add_faults(table: FaultTable, module: _Module) -> None:
    for name, fault in vars(importlib.import_module(f"{module.package}.faults")).items():
        if isinstance(fault, Fault) and _is_written_in(module.tree, name):
            if fault.code in table.faults:
                table.twice.append(fault.code)
            table.faults[fault.code] = fault
            table.names[f"{module.package}.{name}"] = fault.code


def _is_written_in(tree: ast.Module, name: str) -> bool:
    targets = (
        target for node in tree.body if isinstance(node, ast.Assign) for target in node.targets
    )
    return any(isinstance(target, ast.Name) and target.id == name for target in targets)


def _add_errors(table: FaultTable, modules: List[_Module]) -> None:
    classes: Dict[str, Tuple[ast.ClassDef, _Module]] = {}
    used: Set[str] = set()
    for module in modules:
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef):
                classes[node.name] = (node, module)
            used.update(_made(node))
    known = {ROOT_ERROR}
    while True:
        found = {
            name: base
            for name, (node, _module) in classes.items()
            for base in (_name(one) for one in node.bases)
            if base in known and name not in known
        }
        if not found:
            return
        for name, base in found.items():
            node, module = classes[name]
            path = str(module.path.relative_to(SOURCES))
            fault = table.names.get(_own_fault(node, module), "")
            table.errors[name] = ErrorClass(name, base, path, fault, name in used)
        known |= set(found)


def _made(node: ast.AST) -> Iterator[str]:
    """Yield the names of what a node raises or calls."""
    if isinstance(node, ast.Call):
        for one in ast.walk(node.func):
            yield _name(one)
        # Such as functools.partial(SomeError, ...) or failed=SomeError.
        for argument in [*node.args, *(keyword.value for keyword in node.keywords)]:
            yield _name(argument)
    elif isinstance(node, ast.Raise) and node.exc is not None:
        yield _name(node.exc)
    elif isinstance(node, ast.IfExp):
        # Such as kind = NodeLostError if lost else DeviceError.
        yield from (_name(node.body), _name(node.orelse))


def _own_fault(node: ast.ClassDef, module: _Module) -> str:
    for one in node.body:
        targets = one.targets if isinstance(one, ast.Assign) else []
        if isinstance(one, ast.AnnAssign):
            targets = [one.target]
        if any(_name(target) == FAULT_KEYWORD for target in targets):
            return module.constant(one.value)  # type: ignore[attr-defined]
    return ""


def _add_reports(table: FaultTable, module: _Module) -> None:
    for error in table.errors.values():
        if error.used and error.fault:
            table.reported.add(error.fault)
    in_classes = {
        id(one)
        for node in ast.walk(module.tree)
        if isinstance(node, ast.ClassDef)
        for statement in node.body
        if isinstance(statement, (ast.Assign, ast.AnnAssign))
        for one in ast.walk(statement)
    }
    for node in ast.walk(module.tree):
        named = module.constant(node)
        if named in table.names and id(node) not in in_classes:
            table.reported.add(table.names[named])
    for function in _scopes(module.tree):
        for node in ast.walk(function):
            if isinstance(node, ast.Call):
                _add_sentences(table, module, node, function)


def _scopes(tree: ast.Module) -> List[ast.AST]:
    """Return the functions, and the module for what stands outside them."""
    functions = [one for one in ast.walk(tree) if isinstance(one, ast.FunctionDef)]
    return [tree, *functions]


def _add_sentences(table: FaultTable, module: _Module, call: ast.Call, scope: ast.AST) -> None:
    name = _name(call.func)
    if isinstance(call.func, ast.Attribute) and name == FAULT_METHOD and call.args:
        code = table.names.get(module.constant(call.args[0]), "")
        sentences = _templates(call.func.value)
    elif name in table.errors:
        keywords = {one.arg: one.value for one in call.keywords}
        named = module.constant(keywords.get(FAULT_KEYWORD))
        code = table.names.get(named, "") or table.code_of(name)
        sentences = [one for argument in call.args for one in _templates(argument, scope)]
    else:
        return
    for sentence in sentences:
        known = table.sentences.setdefault(code, [])
        if code and sentence not in known:
            known.append(sentence)


def _templates(node: ast.AST, scope: Optional[ast.AST] = None) -> List[str]:
    """Return the templates in an expression; a name stands for what its scope assigns to it."""
    if scope is not None and isinstance(node, ast.Name):
        assigned = [
            one.value
            for one in ast.walk(scope)
            if isinstance(one, ast.Assign) and any(_name(it) == node.id for it in one.targets)
        ]
        return [template for one in assigned for template in _templates(one)]
    return [
        str(one.args[0].value)
        for one in ast.walk(node)
        if isinstance(one, ast.Call)
        and _name(one.func) == "Message"
        and one.args
        and isinstance(one.args[0], ast.Constant)
    ]


def _name(node: ast.AST) -> str:
    return str(getattr(node, "id", getattr(node, "attr", "")))
