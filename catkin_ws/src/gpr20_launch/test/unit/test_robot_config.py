"""The command robot_config: the folder that it creates, its key, the data that it accepts."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from case_kit import each_case

pytest.importorskip("rosgraph")
from gpr20_common.low.clock import Clock
from gpr20_launch.high.robot_config import main
from gpr20_launch.mid.robot_files import read_configuration
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import signature
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse

AXES = Path(__file__).resolve().parents[2] / "config" / "axes.yaml"


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


@pytest.fixture
def robot_config(tmp_path, monkeypatch, capsys):
    """Return a function that runs the command in a folder and returns status and output."""

    def run(action, folder=tmp_path):
        monkeypatch.setattr(sys, "argv", ["robot_config", action, str(folder)])
        status = main()
        printed = capsys.readouterr()
        return status, printed.out + printed.err

    return run


def signing_key(folder):
    return read_configuration(folder, AXES)["storage"].get("signing_key")


def test_the_key_is_made_once_and_named_for_the_storage(tmp_path, robot_config):
    assert robot_config("create")[0] == 0
    (tmp_path / "site.yaml").write_text("robot: GPR-20 Ñandú\n")
    before = (tmp_path / "storage.yaml").read_text()
    status, first = robot_config("key")
    assert status == 0
    key = tmp_path / "signing_key"
    assert signing_key(tmp_path) == str(key)
    assert key.stat().st_mode & 0o777 == 0o600
    changed = set((tmp_path / "storage.yaml").read_text().splitlines()) ^ set(before.splitlines())
    assert changed == {"#signing_key: ''", f'signing_key: "{key}"'}
    kept = key.read_bytes()
    status, again = robot_config("key")
    assert (status, key.read_bytes()) == (0, kept)
    assert first.splitlines()[-4:] == again.splitlines()[-4:]
    assert "GPR-20 Ñandú" in (tmp_path / "signing_key.pub").read_text()


def test_the_line_that_is_printed_accepts_what_the_robot_signs(tmp_path, robot_config):
    _status, printed = robot_config("key")
    (line,) = [one for one in printed.splitlines() if " ssh-ed25519 " in one]
    survey = tmp_path / "survey"
    survey.mkdir()
    (survey / "manifest.json").write_text("{}")
    signature.Signer(tmp_path / "signing_key").sign(survey)
    (tmp_path / "signers").write_text(line)
    found = signature.check_signature(survey, tmp_path / "signers")
    assert (found.signature, found.signer) == (signature.Signature.VALID, "GPR-20")
    assert found.fingerprint in printed


def test_another_key_that_the_configuration_names_is_made_there(tmp_path, robot_config):
    own = tmp_path / "own" / "key"
    own.parent.mkdir()
    (tmp_path / "storage.yaml").write_text(f"signing_key: {own}\n")
    assert robot_config("key")[0] == 0
    assert own.is_file() and not (tmp_path / "signing_key").exists()
    assert (tmp_path / "storage.yaml").read_text() == f"signing_key: {own}\n"


@each_case("text", ["", "signing_key: ''\n", "data: /srv", "data: /srv\n#signing_key: ''\n"])
def test_storage_yaml_names_the_key_once_whatever_it_holds(tmp_path, robot_config, text):
    folder = tmp_path / f"f{len(text)}"
    folder.mkdir()
    (folder / "storage.yaml").write_text(text)
    assert robot_config("key", folder)[0] == 0
    assert signing_key(folder) == str(folder / "signing_key")
    assert read_configuration(folder, AXES)["storage"].get("data") == (
        "/srv" if "data" in text else None
    )


def test_the_configuration_that_surveys_hold_never_has_the_private_key(tmp_path, robot_config):
    robot_config("create")
    robot_config("key")
    stored = json.dumps(read_configuration(tmp_path, AXES))
    secret = "".join((tmp_path / "signing_key").read_text().splitlines()[1:-1])
    assert not any(secret[at : at + 16] in stored for at in range(len(secret) - 16))
    assert robot_config("check")[0] == 0


def test_a_key_that_cannot_be_used_is_an_error(tmp_path, robot_config):
    robot_config("key")
    (tmp_path / "signing_key").chmod(0o644)
    status, printed = robot_config("key")
    assert status == 1
    assert "chmod 600" in printed
    subprocess.run(["chmod", "600", str(tmp_path / "signing_key")], check=True)
    assert robot_config("key")[0] == 0


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
