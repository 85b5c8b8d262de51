"""The wheel of the analysis holds all of this project that it needs: no ROS, no checkout."""

import os
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
    assert not [name for name in names if name.startswith("gpr20_common/high")]
    assert "gpr20_common/translations/es.po" in names
    assert "gpr20_analysis/sample/survey.mcap" in names


@pytest.mark.parametrize("venv", VENVS)
@pytest.mark.parametrize(
    "command",
    [
        ["verify"],
        ["report", "-o", "report.html", "--permittivity", "4"],
        ["report", "-o", "report.html", "--permittivity", "4", "--language", "es"],
    ],
)
def test_the_wheel_alone_reads_a_survey(wheel, tmp_path, command, venv):
    python = ROOT / venv / "bin/python"
    if not python.exists():
        pytest.skip(f"no {venv} here")
    survey = next(one.parent for one in SURVEYS.rglob("manifest.json"))
    # As pip installs it: the catalogue is a file.
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "installed")}
    name, *options = command
    ended = subprocess.run(
        [python, "-m", "gpr20_analysis.commands.main", name, str(survey), *options],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert name != "report" or (tmp_path / "report.html").stat().st_size > 10_000
