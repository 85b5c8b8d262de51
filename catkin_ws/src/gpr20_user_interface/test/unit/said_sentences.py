"""Every sentence that the robot's sources can say to the operator, with 7 for every value."""

import ast
import re
from pathlib import Path
from typing import Iterator, List, Set, Tuple

SOURCES = Path(__file__).resolve().parents[3]
# Whose texts reach main_control's status, its refusals or the nodes' diagnostics.
FILES = (
    *(
        f"gpr20_main_control/src/gpr20_main_control/mid/{name}.py"
        for name in (
            "engine",
            "instruments",
            "main_control",
            "node_liveness",
            "positioner",
            "recovery",
            "repeat_measurement",
            "storage_queue",
            "survey_archive",
            "survey_plan",
            "survey_status",
        )
    ),
    "gpr20_main_control/src/gpr20_main_control/high/ros_axis.py",
    "gpr20_survey/src/gpr20_survey/plan/coverage.py",
    "gpr20_survey/src/gpr20_survey/trace/calibration.py",
    "gpr20_common/src/gpr20_common/high/service_client.py",
    "gpr20_axis_driver/src/gpr20_axis_driver/mid/axis_driver.py",
    "gpr20_axis_driver/src/gpr20_axis_driver/mid/homing.py",
    "gpr20_height_sensor/src/gpr20_height_sensor/mid/height_driver.py",
    "gpr20_vna_acquisition/src/gpr20_vna_acquisition/mid/trace_quality.py",
    "gpr20_survey/src/gpr20_survey/errors.py",
    "gpr20_survey/src/gpr20_survey/files/append_only_file.py",
    "gpr20_survey/src/gpr20_survey/files/regular_file.py",
    "gpr20_vna_processing/src/gpr20_vna_processing/mid/storage_thread.py",
    "gpr20_user_interface/src/gpr20_user_interface/high/control_client.py",
    "gpr20_user_interface/src/gpr20_user_interface/low/profile_folder.py",
    "gpr20_user_interface/src/gpr20_user_interface/mid/profiles.py",
    "gpr20_common/src/gpr20_common/low/yaml_file.py",
)
# Answers that are not shown, lines of the log, faults of launch files, pieces of sentences.
NOT_SHOWN = (
    "control_status says",
    "%s",
    "min_level_db",
    "it must be below",
    "they are ignored: end it",
    "7 7 ",
    "7 could not 7",
    ", ",
    "be ",
)


def said_by_the_robot() -> List[Tuple[str, str]]:
    """Return file and sentence, each once."""
    found: Set[Tuple[str, str]] = set()
    for file in FILES:
        tree = ast.parse((SOURCES / file).read_text(encoding="utf-8"))
        for text in _texts(tree):
            for sentence in text.split("; "):
                if re.search(r"\w+ \w+ \w+", sentence) and not sentence.startswith(NOT_SHOWN):
                    found.add((Path(file).name, sentence))
    return sorted(found)


def _texts(tree: ast.AST) -> Iterator[str]:
    passed: Set[int] = set()
    for node in ast.walk(tree):
        if id(node) in passed:
            passed.update(map(id, ast.iter_child_nodes(node)))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            passed.add(id(node.value))  # a docstring
        elif isinstance(node, ast.JoinedStr):
            passed.update(map(id, ast.iter_child_nodes(node)))
            yield _example(node)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def _example(text: ast.JoinedStr) -> str:
    pieces = [str(part.value) if isinstance(part, ast.Constant) else "7" for part in text.values]
    # A remark that follows without a space may be empty.
    if len(pieces) > 1 and pieces[-1] == "7" and pieces[-2][-1].isalpha():
        pieces.pop()
    return "".join(pieces)
