"""The wheel of the analysis holds all of this project that it needs: no ROS, no checkout.

That of a wing holds the wing alone, and adds what it offers.
"""

import re
import shlex
import sys
import zipfile

import numpy as np
import pytest
from storage_kit import Kit
from trace_examples import METADATA, POINTS, planned_trace
from user_shell import ROOT, printed_by

pytestmark = pytest.mark.release
SOURCES = ROOT / "catkin_ws/src"
# They have what the requirements name and neither ROS nor this project.
VENVS = [".venv313", ".venv38"]
FORMATS, VIEWER = "gpr20_foreign_formats", "gpr20_viewer"


def wheel_of(package, folder):
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder]
    printed_by(*pip, SOURCES / package)
    (path,) = folder.glob(f"{package}-*.whl")
    return path


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return wheel_of("gpr20_analysis", tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def wings(tmp_path_factory):
    return {one: wheel_of(one, tmp_path_factory.mktemp(one)) for one in (FORMATS, VIEWER)}


@pytest.fixture(params=VENVS)
def gpr20(request, wheel, wings, tmp_path):
    """A function that runs gpr20 from the wheels, under a Python without ROS."""
    python = ROOT / request.param / "bin/python"
    if not python.exists():
        pytest.skip(f"no {request.param} here")
    # As pip installs it: the catalogue is a file.
    for path in (wheel, *wings.values()):
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path / "installed")

    def run(*arguments):
        command = [python, "-m", "gpr20_analysis.commands.main", *arguments]
        return printed_by(*command, folder=tmp_path, PYTHONPATH=str(tmp_path / "installed"))

    return run


def test_the_wheel_alone_reads_a_survey(gpr20, tmp_path):
    kit = Kit(tmp_path / "data")
    survey = kit.open(metadata_json=METADATA)
    kit.finish(map(planned_trace, range(len(POINTS))), ())
    kit.processing.shut_down()
    gpr20("verify", str(survey))
    report = ["report", str(survey), "-o", "report.html", "--permittivity", "4"]
    gpr20(*report, "--language", "es")
    assert (tmp_path / "report.html").stat().st_size > 10_000


def test_the_wheel_of_the_foreign_formats_adds_them(gpr20, tmp_path):
    hz = np.linspace(1e9, 2e9, 11)
    np.savez(tmp_path / "l.npz", s21=np.ones((3, 11)) * 1j, x_m=[0.0, 0.1, 0.2], frequency_hz=hz)
    assert "x 3, frequency 11" in gpr20("import", "l.npz", "l.nc", "--format", "arrays")


def test_the_commands_of_the_readme_show_the_sample_without_ros(gpr20, tmp_path):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    section = readme.split("## Look at a sample survey without ROS\n")[1].split("\n## ")[0]
    make, activate, install, *commands = section.split("```\n")[1].splitlines()
    # Debian's and Ubuntu's pip refuse to install outside of a virtual environment.
    assert make == "python3 -m venv ~/gpr20_venv"
    assert activate == "source ~/gpr20_venv/bin/activate"
    assert install == "pip install 'catkin_ws/src/gpr20_analysis[all]'"
    printed = "".join(gpr20(*shlex.split(command)[1:]) for command in commands)
    # Three bodies are buried below the sample; the wire, of 120 mm, is two places.
    assert "Places to check: 6 " in printed
    # Of the real line the bars come first, with their depths; see test_public_interface.py.
    assert re.search(r"^C14 +\d+ .*$", printed, re.MULTILINE)
    assert (tmp_path / "report.html").stat().st_size > 100_000
