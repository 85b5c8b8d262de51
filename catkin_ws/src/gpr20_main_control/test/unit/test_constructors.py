"""What the parts of the main control share is passed as one object."""

import ast
from pathlib import Path

import gpr20_main_control

MOST_ARGUMENTS = 6


def constructors():
    """Yield each class and its constructor; dataclasses, whose fields are data, have none."""
    for path in Path(gpr20_main_control.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef):
                for one in node.body:
                    if isinstance(one, ast.FunctionDef) and one.name == "__init__":
                        yield node.name, one.args


def test_no_constructor_takes_more_than_six_collaborators():
    counts = {
        name: len([*args.posonlyargs, *args.args, *args.kwonlyargs]) - 1
        for name, args in constructors()
    }
    assert {"MainControlNode", "StepActions", "SurveyEnding"} <= set(counts)
    assert {name: count for name, count in counts.items() if count > MOST_ARGUMENTS} == {}
