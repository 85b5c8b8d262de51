"""Run the cells of a notebook in this interpreter and keep what they show in it.

Usage: run_notebook.py NOTEBOOK

It needs neither Jupyter nor a kernel: text that is printed, the value of a cell's last line, and
figures are stored as outputs.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import sys
from pathlib import Path
from typing import Any, Dict, List

from matplotlib.figure import Figure

RESOLUTION_DPI = 70


def run_cells(notebook: Dict[str, Any]) -> Dict[str, Any]:
    """Run all code cells in order, store their outputs, and return the names they made."""
    names: Dict[str, Any] = {"__name__": "__main__"}
    for count, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] == "code":
            cell["outputs"] = _run("".join(cell["source"]), names, f"<cell {count}>")
    return names


def _run(source: str, names: Dict[str, Any], title: str) -> List[Dict[str, Any]]:
    tree = ast.parse(source, title)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, title, "exec"), names)  # noqa: S102 a notebook of this project
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), title, "eval"), names)  # noqa: S307
    outputs: List[Dict[str, Any]] = []
    if printed.getvalue():
        text = printed.getvalue().splitlines(keepends=True)
        outputs.append({"output_type": "stream", "name": "stdout", "text": text})
    if value is not None:
        outputs.append({"output_type": "display_data", "metadata": {}, "data": _shown(value)})
    return outputs


def _shown(value: object) -> Dict[str, Any]:
    if not isinstance(value, Figure):
        return {"text/plain": repr(value).splitlines(keepends=True)}
    picture = io.BytesIO()
    value.savefig(picture, format="png", dpi=RESOLUTION_DPI)
    return {"image/png": base64.b64encode(picture.getvalue()).decode(), "text/plain": ["figure"]}


if __name__ == "__main__":
    path = Path(sys.argv[1])
    content = json.loads(path.read_text(encoding="utf-8"))
    run_cells(content)
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
