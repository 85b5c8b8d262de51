"""The notebook runs on the sample survey, finds its targets, and shows what a run prints."""

from __future__ import annotations

import copy
import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[6]
NOTEBOOK = ROOT / "docs" / "from_survey_to_image.ipynb"
NUMBER = re.compile(r"[-+]?\d+\.?\d*")
TARGETS_MM = [(173.3, 181.7, 113.0), (318.9, 207.4, 71.0)]
"""Sphere and disc of imaging_targets.yaml."""


@pytest.fixture(scope="module")
def runner():
    specification = importlib.util.spec_from_file_location(
        "run_notebook", ROOT / "tools/pages/run_notebook.py"
    )
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def stored():
    return json.loads(NOTEBOOK.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def ran(runner, stored):
    notebook = copy.deepcopy(stored)
    return notebook, runner.run_cells(notebook)


def test_it_finds_the_point_targets(ran):
    _, names = ran
    found_mm = 1e3 * np.array(
        [(one.x_m, one.y_m, one.depth_m) for one in names["found"].candidates]
    )
    for target_mm in TARGETS_MM:
        assert min(np.linalg.norm(found_mm - target_mm, axis=1)) < 6.0


def test_it_shows_its_figures_and_what_a_run_prints_today(ran, stored):
    notebook, _ = ran
    for made, kept in zip(notebook["cells"], stored["cells"]):
        new, old = printed(made), printed(kept)
        assert NUMBER.sub("#", new) == NUMBER.sub("#", old), "run tools/pages/run_notebook.py"
        numbers = [[float(one) for one in NUMBER.findall(text)] for text in (new, old)]
        # The last digit may be another one with other versions of the libraries.
        assert numbers[0] == pytest.approx(numbers[1], rel=0.01, abs=0.2)
        assert pictures(made) == pictures(kept)
    assert sum(map(pictures, stored["cells"])) == 4


def printed(cell):
    text = " ".join("".join(one.get("text", "")) for one in cell.get("outputs", []))
    return " ".join(text.split())


def pictures(cell):
    return sum("image/png" in one.get("data", {}) for one in cell.get("outputs", []))


def test_it_needs_nothing_but_the_package(stored):
    source = "".join(line for cell in stored["cells"] for line in cell["source"])
    for other in ("gpr20_simulator", "rospy", "catkin_ws", "scenes /"):
        assert f"import {other}" not in source
