"""The command robot_config: which folder it creates, and which data folder it accepts."""

import sys

import pytest
from case_kit import each_case

pytest.importorskip("rosgraph")
from gpr20_common.low.clock import Clock
from gpr20_launch.high.robot_config import main
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse


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


def test_another_data_folder_is_used_after_somebody_has_accepted_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    monkeypatch.setenv("GPR20_STATE", str(tmp_path / "state"))
    (tmp_path / "storage.yaml").write_text(f"data: {tmp_path}/data")
    folder = DataFolder(DataFolderUse(tmp_path / "data", tmp_path / "state"), Clock())
    folder.check()
    former = folder.identify().identity
    (tmp_path / "data").rename(tmp_path / "moved")
    with pytest.raises(SurveyRefusedError):
        folder.check()
    monkeypatch.setattr(sys, "argv", ["robot_config", "accept_data"])
    assert main() == 0
    folder.check()
    identity = folder.identify().identity
    assert identity != former and identity in capsys.readouterr().out
