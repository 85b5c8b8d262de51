"""The contracts on imports (pyproject.toml) cover every package and refuse what they should."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from wings_kit import NEEDS_ALL

# The contracts name every package.
pytestmark = NEEDS_ALL

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted(
    [*ROOT.glob("catkin_ws/src/*/src/*/__init__.py"), *ROOT.glob("deploy/*/*/__init__.py")],
    key=lambda one: one.parent.name,
)


@pytest.fixture
def copy(tmp_path):
    """Return the folder of a copy of all packages."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for source in SOURCES:
        skipped = shutil.ignore_patterns("__pycache__")
        shutil.copytree(source.parent, tmp_path / source.parent.name, ignore=skipped)
    return tmp_path


def broken(folder):
    """Return what lint-imports says of a folder; empty if all contracts are kept."""
    ended = subprocess.run(
        ["lint-imports", "--no-cache", "--no-logo"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "1000"},
        capture_output=True,
        text=True,
        check=False,
    )
    return "" if ended.returncode == 0 else ended.stdout


def test_every_package_is_covered():
    contracts = (ROOT / "pyproject.toml").read_text()
    roots = contracts.split("root_packages = [")[1].split("]")[0]
    assert re.findall(r'"(\w+)"', roots) == [one.parent.name for one in SOURCES]


def test_the_packages_keep_the_contracts(copy):
    assert broken(copy) == ""


SHARE = "move what both need to gpr20_survey or gpr20_common, or send it as a message of gpr20_msgs"
PASS_IN = "pass the object from the higher level in as an argument, or move the code down"
ROS_IN_HIGH = "do it in high/ and pass plain values or a function to the lower level"


@pytest.mark.parametrize(
    "file, line, remedy",
    [
        ("gpr20_common/mid/checks.py", "import gpr20_common.high.node", PASS_IN),
        ("gpr20_common/low/clock.py", "import gpr20_common.mid.checks", PASS_IN),
        ("gpr20_common/errors.py", "import gpr20_survey.errors", SHARE),
        ("gpr20_survey/errors.py", "import rospy", ROS_IN_HIGH),
        (
            "gpr20_main_control/mid/devices/robot.py",
            "from sensor_msgs.msg import Range",
            ROS_IN_HIGH,
        ),
        ("gpr20_main_control/high/__init__.py", "import gpr20_axis_driver.errors", SHARE),
        ("gpr20_axis_driver/high/__init__.py", "import gpr20_simulator.errors", SHARE),
        ("gpr20_vna_acquisition/mid/analyzers.py", "import gpr20_scikit_rf", SHARE),
        ("gpr20_vna_acquisition/mid/analyzers.py", "import pyvisa", "do it in gpr20_scikit_rf"),
        (
            "gpr20_scikit_rf/errors.py",
            "import gpr20_simulator.errors",
            "move what it needs there",
        ),
        (
            "gpr20_simulator/high/__init__.py",
            "import gpr20_main_control.errors",
            "use the topics and services of the other nodes",
        ),
        (
            "gpr20_simulator/mid/world/ground.py",
            "import gpr20_survey.radar.refraction",
            "solve it in gpr20_simulator, by another method",
        ),
        (
            "gpr20_height_sensor/high/__init__.py",
            "from PyQt5.QtCore import QObject",
            "do it there and pass plain values or a function to the other code",
        ),
        (
            "gpr20_viewer/session.py",
            "import pyqtgraph",
            "do it there and pass plain values or a function to the other code",
        ),
        (
            "gpr20_viewer/session.py",
            "import gpr20_viewer.views.main_window",
            "pass plain values or a function in",
        ),
        (
            "gpr20_viewer/session.py",
            "import gpr20_imaging.errors",
            "let gpr20_analysis offer what it needs",
        ),
        ("gpr20_web/roles.py", "import gpr20_user_interface.window", SHARE),
        ("gpr20_web/roles.py", "import gpr20_analysis.errors", "ask that worker"),
        ("gpr20_web/mid/web_page.py", "import rospy", ROS_IN_HIGH),
        ("gpr20_web/mid/web_page.py", "import tornado.web", "let these offer what is needed"),
        ("gpr20_web/low/http_server.py", "import apprise", "let these offer what is needed"),
        ("gpr20_analysis/errors.py", "import gpr20_viewer.picks", SHARE),
        ("gpr20_analysis/errors.py", "import gpr20_foreign_formats.kirchhoff", SHARE),
        (
            "gpr20_foreign_formats/kirchhoff.py",
            "import gpr20_imaging.errors",
            "let gpr20_analysis offer what it needs",
        ),
    ],
)
def test_an_import_that_is_not_allowed_is_refused_with_what_to_do(copy, file, line, remedy):
    with (copy / file).open("a") as source:
        source.write(f"{line}\n")
    _kept, failed = broken(copy).split("Broken contracts")
    assert remedy in failed
