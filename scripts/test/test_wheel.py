"""The wheel of the analysis holds all of this project that it needs: no ROS, no checkout."""

import os
import shlex
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.takes(60)

ROOT = Path(__file__).resolve().parents[2]
PROJECT = ROOT / "catkin_ws/src/gpr20_analysis"
SURVEYS = ROOT / "catkin_ws/src/gpr20_vna_processing/test/unit/old_surveys/without_header"
# They have what the requirements name and neither ROS nor this project.
VENVS = [".venv38", ".venv313"]
PACKAGES = {"gpr20_analysis", "gpr20_common", "gpr20_survey"}
LIMIT_S = 300


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder)]
    subprocess.run([*pip, str(PROJECT)], check=True, timeout=LIMIT_S)
    (path,) = folder.glob("*.whl")
    return path


def test_the_wheel_holds_the_analysis_and_what_a_survey_is(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {name.split("/")[0] for name in names if "dist-info" not in name} == PACKAGES
    assert not [name for name in names if "/high/" in name.replace("gpr20_analysis/high/", "")]
    assert "gpr20_common/translations/es.po" in names
    assert "gpr20_analysis/sample/survey.mcap" in names


@pytest.fixture(params=VENVS)
def gpr20(request, wheel, tmp_path):
    """A function that runs gpr20 from the wheel, under a Python without ROS."""
    python = ROOT / request.param / "bin/python"
    if not python.exists():
        pytest.skip(f"no {request.param} here")
    # As pip installs it: the catalogue is a file.
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")

    def run(*arguments):
        ended = subprocess.run(
            [python, "-m", "gpr20_analysis.commands.main", *arguments],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(tmp_path / "installed")},
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
        )
        assert ended.returncode == 0, ended.stdout + ended.stderr
        return ended.stdout

    return run


def test_the_wheel_alone_reads_a_survey(gpr20, tmp_path):
    survey = next(one.parent for one in SURVEYS.rglob("manifest.json"))
    gpr20("verify", str(survey))
    report = ["report", str(survey), "-o", "report.html", "--permittivity", "4"]
    gpr20(*report, "--language", "es")
    assert (tmp_path / "report.html").stat().st_size > 10_000


def test_the_commands_of_the_readme_show_the_sample_without_ros(gpr20, tmp_path):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    section = readme.split("## Look at a sample survey without ROS\n")[1].split("\n## ")[0]
    make, activate, install, *commands = section.split("```\n")[1].splitlines()
    # Debian's and Ubuntu's pip refuse to install outside of a virtual environment.
    assert make == "python3 -m venv ~/gpr20_venv"
    assert activate == "source ~/gpr20_venv/bin/activate"
    assert install == "pip install 'catkin_ws/src/gpr20_analysis[all]'"
    printed = "".join(gpr20(*shlex.split(command)[1:]) for command in commands)
    # Three bodies are buried below the sample.
    assert "candidates: 3," in printed
    assert (tmp_path / "report.html").stat().st_size > 100_000
