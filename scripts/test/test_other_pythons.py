"""The code works under the other Pythons that it is written for.

scripts/test.sh makes a virtual environment for each of them that this machine has, for a release.
"""

from __future__ import annotations

import os

import pytest
from pytest_gpr20 import without_ros
from user_shell import ROOT, printed_by

EVERYTHING = sorted(path.parts[-3] for path in ROOT.glob("catkin_ws/src/*/test/unit"))
ANALYSIS = {"gpr20_analysis", "gpr20_foreign_formats", "gpr20_imaging", "gpr20_viewer"}
# Version, virtual environment and what is written for it: the Python of ROS Noetic, and a new one,
# as the analysis also runs on other computers.
PYTHONS = [
    ("3.8", ".venv38", EVERYTHING),
    ("3.13", ".venv313", ["gpr20_analysis", "gpr20_common", "gpr20_survey"]),
]
# The libraries that Ubuntu 20.04 brings, on demand: CONTRIBUTING.md. The analysis needs later ones.
if "GPR20_UBUNTU_VENV" in os.environ:
    on_robot = sorted({*EVERYTHING} - ANALYSIS - {"gpr20_scikit_rf"})
    PYTHONS.append(("ubuntu20.04", os.environ["GPR20_UBUNTU_VENV"], on_robot))


@pytest.mark.release
@pytest.mark.parametrize("version, venv, packages", PYTHONS, ids=[one[0] for one in PYTHONS])
def test_the_unit_tests_pass_under(version, venv, packages, request):
    program = ROOT / venv / "bin/python"
    if not program.exists():
        pytest.skip(f"no Python {version} here ({venv})")
    cache = request.config.cache.mkdir(f"python{version}")
    tests = [f"catkin_ws/src/{package}/test/unit" for package in packages]
    options = ["-q", "-p", "no:xdist", "-o", f"cache_dir={cache}"]
    # What is random is drawn under Debian's Python.
    options.append("--hypothesis-profile=few_examples")
    own = {name: value for name, value in os.environ.items() if "PYTEST" not in name}
    environment = {**own, **without_ros({}), "GPR20_LONG": ""}
    printed_by(program, "-m", "pytest", *options, *tests, folder=ROOT, env=environment)
