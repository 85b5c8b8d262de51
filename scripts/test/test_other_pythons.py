"""The code works under the other Pythons that it is written for.

scripts/test.sh makes a virtual environment for each of them that this machine has, for a release.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple, Sequence

import pytest
from pytest_gpr20 import without_ros
from user_shell import ROOT, printed_by

EVERYTHING = sorted(path.parts[-3] for path in ROOT.glob("catkin_ws/src/*/test/unit"))
ANALYSIS = ["gpr20_analysis", "gpr20_foreign_formats", "gpr20_imaging", "gpr20_viewer"]
# What these computers have no use for: ROS, and what the robot's pins and buses need.
ABSENT = "actionlib diagnostic_msgs diagnostic_updater genpy geometry_msgs gpr20_msgs rosbag"
ABSENT += " roslaunch rosgraph rosgraph_msgs roslib rospkg rospy sensor_msgs spidev std_msgs"
ABSENT += " std_srvs tf2_msgs tf2_ros visualization_msgs RPi"
IMPORT_ALL = """
import importlib, pkgutil, sys
absent = set(sys.argv[1].split())
for package in sys.argv[2:]:
    path = importlib.import_module(package).__path__
    for module in pkgutil.walk_packages(path, package + "."):
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            if error.name.split(".")[0] not in absent:
                raise
"""


class OtherPython(NamedTuple):
    """A Python without ROS: its version, its venv in the checkout, and what is written for it."""

    version: str
    venv: str
    packages: Sequence[str]

    @property
    def program(self) -> Path:
        """The interpreter."""
        return ROOT / self.venv / "bin/python"


# That of ROS Noetic, and a new one: the analysis also runs on other computers.
PYTHONS = [
    OtherPython("3.8", ".venv38", EVERYTHING),
    OtherPython("3.13", ".venv313", ["gpr20_analysis", "gpr20_common", "gpr20_survey"]),
]
# The libraries that Ubuntu 20.04 brings, on demand: CONTRIBUTING.md. The analysis needs later ones.
if "GPR20_UBUNTU_VENV" in os.environ:
    on_robot = sorted({*EVERYTHING} - {*ANALYSIS, "gpr20_scikit_rf"})
    PYTHONS.append(OtherPython("ubuntu20.04", os.environ["GPR20_UBUNTU_VENV"], on_robot))


def run(python: str, *arguments: str, **variables: str) -> None:
    """Run a program of Python in the checkout; it must succeed."""
    own = {name: value for name, value in os.environ.items() if "PYTEST" not in name}
    printed_by(python, *arguments, folder=ROOT, env={**own, **variables})


@pytest.fixture(params=PYTHONS, ids=lambda python: python.version)
def python(request):
    """Each of the Pythons that this machine has."""
    if not request.param.program.exists():
        pytest.skip(f"no Python {request.param.version} here ({request.param.venv})")
    return request.param


@pytest.mark.release
def test_the_unit_tests_pass_under(python, request):
    cache = request.config.cache.mkdir(f"python{python.version}")
    tests = [f"catkin_ws/src/{package}/test/unit" for package in python.packages]
    options = ["-q", "-p", "no:xdist", "-o", f"cache_dir={cache}"]
    # What is random is drawn under Debian's Python.
    options.append("--hypothesis-profile=few_examples")
    variables = {**without_ros({}), "GPR20_LONG": ""}
    run(str(python.program), "-m", "pytest", *options, *tests, **variables)


@pytest.mark.release
def test_every_module_is_imported_under(python):
    with_code = [one for one in python.packages if (ROOT / f"catkin_ws/src/{one}/src").is_dir()]
    run(str(python.program), "-c", IMPORT_ALL, ABSENT, *with_code, **without_ros({}))
