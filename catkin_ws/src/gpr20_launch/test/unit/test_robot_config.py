"""The command robot_config: which folder it creates."""

import sys

import pytest
from case_kit import each_case

pytest.importorskip("rosgraph")
from gpr20_launch.high.robot_config import main


@each_case("variable", ["", "another"])
def test_the_folder_is_the_one_that_a_launch_reads(tmp_path, monkeypatch, variable):
    home = tmp_path / f"home {variable}"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("GPR20_CONFIG", str(home / variable) if variable else "")
    monkeypatch.setattr(sys, "argv", ["robot_config", "create"])
    assert main() == 0
    folder = home / (variable or ".gpr20/robot")
    assert (folder / "analyzer.yaml").is_file()
    assert [path.name for path in home.iterdir()] == [variable or ".gpr20"]
