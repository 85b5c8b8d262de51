"""The files of the robot's configuration, and the command that makes them, a key and its data."""

import dataclasses
import json
import re
from pathlib import Path

import pytest
import yaml
from case_kit import each_case
from robot_check_examples import AXES, checked

from gpr20_common.mid.codec import record_from
from gpr20_launch.mid.robot_files import AXES_FILE, FILES, Reading
from gpr20_launch.mid.written_files import templates
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import manifest, signature
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse
from gpr20_survey.folder.log_record import Kind, LogRecord

DOCS = Path(__file__).resolve().parents[5] / "docs"


def read(folder, **texts):
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    reading = Reading(folder, AXES)
    assert not reading.problems
    return reading.sections


def test_without_files_everything_has_its_default(tmp_path):
    sections = read(tmp_path)
    assert sections["x_axis"]["max_coord"] == 650.0
    for file in FILES.values():
        for section, kind in file.items():
            assert record_from(kind, sections[section], section) == kind()


def test_the_first_page_and_its_picture_have_the_pins_of_the_default_configuration():
    signals = {"direction": "dir_pin", "step": "step_pin", "endstop": "sensor_pin"}
    pins = {
        f"{axis.upper()} {signal}": values[key]
        for axis, values in yaml.safe_load(AXES.read_text()).items()
        for signal, key in signals.items()
        if key in values
    }
    page = (DOCS / "first_real_survey.md").read_text()
    rows = re.findall(r"^\| (\d+) \| ([XYZ] \w+) \|", page, re.MULTILINE)
    assert {signal: int(pin) for pin, signal in rows} == pins
    picture = (DOCS / "images/wiring.svg").read_text()
    assert [one for one in pins.items() if ">{} {}<".format(*one) not in picture] == []


def test_a_template_is_correct_and_shows_every_key_with_its_default(tmp_path):
    texts = templates(yaml.safe_load(AXES.read_text()))
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert read(tmp_path) == read(tmp_path / "none")
    for name, file in FILES.items():
        lines = [one for one in texts[name].splitlines() if re.match("#[^ ]", one)]
        (tmp_path / name).write_text("\n".join(one[1:] for one in lines))
        shown = yaml.safe_load((tmp_path / name).read_text())
        for kind in file.values():
            own = {field.name: shown[field.name] for field in dataclasses.fields(kind)}
            assert record_from(kind, own, name) == kind()
    used = [line.replace("  #", "  ", 1) for line in texts[AXES_FILE].splitlines()]
    sections = read(tmp_path, axes="\n".join(used))
    for axis, values in yaml.safe_load(AXES.read_text()).items():
        assert {key: sections[f"{axis}_axis"][key] for key in values} == values
    assert not [one for one in checked(tmp_path, part="robot") if one.refuses]


def test_a_file_of_another_name_is_refused_and_what_editors_leave_is_not_read(tmp_path):
    (tmp_path / ".#axes.yaml").symlink_to("somebody@somewhere.1234")
    (tmp_path / "._site.yaml").write_bytes(b"\0\1")
    (tmp_path / "axes.yaml~").write_text("x: 5")
    assert read(tmp_path) == read(tmp_path / "none")
    for name in ("Axes.yaml", "axes.yml", "hight.yaml"):
        (tmp_path / name).write_text("")
        (one,) = Reading(tmp_path, AXES).problems
        assert one.file == str(tmp_path / name) and one.refuses
        (tmp_path / name).unlink()
    # A link that leads nowhere does not mean the defaults.
    (tmp_path / "axes.yaml").symlink_to("/nowhere/axes.yaml")
    (tmp_path / "linked").symlink_to("/nowhere")
    for folder in (tmp_path, tmp_path / "linked"):
        assert any(str(folder) in one.file for one in Reading(folder, AXES).problems)


@pytest.fixture
def robot_config(tmp_path, run):
    """Return a function that runs the command in a folder and returns status and output.

    Without a folder, it is the one of the environment.
    """

    def run_it(action, folder=tmp_path):
        status, *printed = run("robot_config", action, *([folder] if folder else []))
        return status, "".join(printed)

    return run_it


def test_the_folder_is_the_one_that_a_launch_reads(tmp_path, monkeypatch, robot_config):
    monkeypatch.setenv("HOME", str(tmp_path))
    for variable in ("", str(tmp_path / "another")):
        monkeypatch.setenv("GPR20_CONFIG", variable)
        assert robot_config("create", None)[0] == 0
        assert (Path(variable or tmp_path / ".gpr20/robot") / "analyzer.yaml").is_file()
    assert {path.name for path in tmp_path.iterdir()} == {".gpr20", "another"}


def signing_key(folder):
    return read(folder)["storage"].get("signing_key")


def test_the_key_is_made_once_named_for_the_storage_and_never_in_a_survey(tmp_path, robot_config):
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
    stored = json.dumps(read(tmp_path))
    secret = "".join(key.read_text().splitlines()[1:-1])
    assert not any(secret[at : at + 16] in stored for at in range(len(secret) - 16))
    assert robot_config("check")[0] == 0
    key.chmod(0o644)
    status, printed = robot_config("key")
    assert status == 1 and "chmod 600" in printed
    key.chmod(0o600)
    assert robot_config("key")[0] == 0


@each_case("name", ["GPR-20", 'a"b,*!? #x', "名"])
@each_case("text", ["", "signing_key: ''\n", "data: /srv\n#signing_key: ''\n"])
def test_the_line_that_is_printed_accepts_what_the_robot_signs(tmp_path, robot_config, name, text):
    folder = tmp_path / f"{len(name)}_{len(text)}"
    folder.mkdir()
    (folder / "site.yaml").write_text(json.dumps({"robot": name}))
    (folder / "storage.yaml").write_text(text)
    _status, printed = robot_config("key", folder)
    storage = read(folder)["storage"]
    assert storage["signing_key"] == str(folder / "signing_key")
    assert storage.get("data") == ("/srv" if "data" in text else None)
    (line,) = [one for one in printed.splitlines() if " ssh-ed25519 " in one]
    (folder / "signers").write_text(line)
    plan = LogRecord.after(None, Kind.PLAN, {}, "2026")
    manifest.write_manifest(folder, "0f8fad5b", plan, "1.2.3", "2026")
    signature.Signer(folder / "signing_key").sign(folder)
    content, fingerprint = signature.signed_manifest(folder)
    signed = ("-s", folder / manifest.SIGNATURE_FILE, "-f", folder / "signers")
    verify = ("-Y", "verify", "-n", signature.NAMESPACE, *signed, "-I", line.split()[0])
    assert signature.ssh_keygen(verify, content).yes
    assert fingerprint in printed


def test_another_data_folder_is_used_after_somebody_has_accepted_it(
    tmp_path, monkeypatch, robot_config
):
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    monkeypatch.setenv("GPR20_STATE", str(tmp_path / "state"))
    (tmp_path / "storage.yaml").write_text(f"data: {tmp_path}/data")
    folder = DataFolder(DataFolderUse(tmp_path / "data", tmp_path / "state"))
    folder.check()
    former = folder.identify().identity
    (tmp_path / "data").rename(tmp_path / "moved")
    with pytest.raises(SurveyRefusedError):
        folder.check()
    status, printed = robot_config("accept_data", None)
    assert status == 0
    folder.check()
    identity = folder.identify().identity
    assert identity != former and identity in printed
