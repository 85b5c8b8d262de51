"""The command robot_config: which folder it creates."""

import sys

import pytest

pytest.importorskip("rosgraph")
from gpr20_launch.high.robot_config import main


@pytest.mark.parametrize("variable", ["", "another"])
def test_the_folder_is_the_one_that_a_launch_reads(tmp_path, monkeypatch, variable):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path / variable) if variable else "")
    monkeypatch.setattr(sys, "argv", ["robot_config", "create"])
    assert main() == 0
    folder = tmp_path / (variable or ".gpr20/robot")
    assert (folder / "analyzer.yaml").is_file()
    assert [path.name for path in tmp_path.iterdir()] == [variable or ".gpr20"]
