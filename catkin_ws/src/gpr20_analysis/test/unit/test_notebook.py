"""The worked notebook runs from top to bottom and finds what its scene holds."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[5]
NOTEBOOK = ROOT / "docs" / "from_survey_to_image.ipynb"


def runner():
    specification = importlib.util.spec_from_file_location(
        "run_notebook", ROOT / "scripts" / "run_notebook.py"
    )
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_notebook_runs_and_finds_the_point_targets():
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    names = runner().run_cells(notebook)
    sphere, disc, _wire = names["scene"].targets
    for target in (sphere, disc):
        away_mm = [
            np.linalg.norm(
                [
                    echo.x_m * 1e3 - target.x_mm,
                    echo.y_m * 1e3 - target.y_mm,
                    (echo.depth_m - target.depth_m) * 1e3,
                ]
            )
            for echo in names["found"].candidates
        ]
        assert min(away_mm) < 5.0
    pictures = [
        output
        for cell in notebook["cells"]
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 4
