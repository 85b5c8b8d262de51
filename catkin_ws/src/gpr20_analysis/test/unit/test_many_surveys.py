"""The program of docs/several_robots.md images each survey of a folder on a cluster."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from distributed import LocalCluster
from tutorial_code import code_blocks

from gpr20_analysis import load_survey, sample_survey

pytestmark = pytest.mark.real_time
PAGE = Path(__file__).resolve().parents[5] / "docs" / "several_robots.md"


def test_every_survey_is_imaged_and_a_damaged_one_is_named(tmp_path):
    program = tmp_path / "image_surveys.py"
    program.write_text(code_blocks(PAGE, "python")[program.name])
    data, output = tmp_path / "data", tmp_path / "images"
    output.mkdir()
    for name in ("first", "second", "damaged"):
        (data / name).mkdir(parents=True)
        shutil.copy(sample_survey(), data / name)
    (data / "damaged" / "survey.mcap").write_bytes(b"no MCAP")
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        command = [sys.executable, str(program), str(data), cluster.scheduler_address, str(output)]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0, ended.stderr
    assert sorted(file.name for file in output.iterdir()) == ["first.nc", "second.nc"], ended.stderr
    assert (load_survey(output / "first.nc").image.values.max()) > 0.0
    (named,) = [line for line in ended.stderr.splitlines() if str(data) in line]
    assert "damaged" in named
