"""The bundle for remote help: what is in it, what is not, and what never is."""

import json
import os
import zipfile
from unittest import mock

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from test_probes import tree
from test_robot_checks import facts

from gpr20_doctor.low.bundle_sources import (
    REMOVED,
    end_of,
    json_without_secrets,
    without_secrets,
)
from gpr20_doctor.mid import bundle
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_request import ThisMachine
from gpr20_doctor.mid.robot_facts import Evidence, unheard

SECRET = "hunter2hunter2"
KEY = f"-----BEGIN OPENSSH PRIVATE KEY-----\n{SECRET}\n-----END OPENSSH PRIVATE KEY-----\n"
SURVEY = "20260731T101500_0f8fad5b"


@pytest.fixture(autouse=True)
def at_full_speed():
    # A process cannot take its niceness back.
    with mock.patch("os.nice") as nice:
        yield nice


@pytest.fixture
def machine(tmp_path):
    """A robot's computer with services, one survey, logs, and secrets wherever they could lie."""

    files = {
        "etc/gpr20/environment": f"GPR20_CONFIG={tmp_path}/robot\nGPR20_TOKEN={SECRET}\n",
        "etc/os-release": "ID=debian\n",
        "robot/site.yaml": f"robot: Mole\nwifi_password: {SECRET}, and more {SECRET}\n",
        "robot/storage.yaml": f"signing_key: signing_key\ntokens:\n  - {SECRET}\n- {SECRET}\n",
        "robot/analyzer.yaml": f"# secret: {SECRET}\npassphrase: |\n  {SECRET}\n\n  {SECRET}\n",
        "robot/height.yaml": KEY,
        "robot/signing_key": KEY,
        "robot/accounts.yaml": f"kim: {SECRET}\n",
        "logs/run/master.log": f"http://kim:{SECRET}@10.0.0.1/ Authorization: Basic {SECRET}\n"
        f"token={SECRET}\n{KEY}fine\n",
        f"data/{SURVEY}/survey.json": json.dumps({"id": "x", "api_key": [SECRET]}),
        f"data/{SURVEY}/log.jsonl": f'{{"plan": 1}}\n{{"password": "{SECRET}"}}\n',
        f"data/{SURVEY}/traces/000001.json": "a trace",
    }
    tree(tmp_path, **files)
    (tmp_path / "logs/latest").symlink_to("run")
    (tmp_path / "logs/stolen.log").symlink_to(tmp_path / "robot/signing_key")
    os.mkfifo(str(tmp_path / "logs/pipe.log"))
    environment = {
        "GPR20_DATA": str(tmp_path / "data"),
        "ROS_LOG_DIR": str(tmp_path / "logs"),
        "GPR20_STATE": str(tmp_path / "state"),
    }
    return ThisMachine("pi", environment, tmp_path)


def written(tmp_path, machine, robot=None):
    """Write a bundle; return its parts and what is missing."""
    robot = robot or facts()
    request = machine.request({})
    missing = bundle.write_bundle(tmp_path / "help.zip", findings(robot, None), robot, request)
    with zipfile.ZipFile(tmp_path / "help.zip") as archive:
        parts = {name: archive.read(name).decode() for name in archive.namelist()}
    assert json.loads(parts["index.json"])["missing"] == missing
    assert sorted(json.loads(parts["index.json"])["parts"]) == sorted({*parts} - {"index.json"})
    return parts, missing


def test_the_parts_are_there_and_no_secret_is(tmp_path, machine, at_full_speed):
    parts, missing = written(tmp_path, machine)
    at_full_speed.assert_called_once_with(bundle.NICENESS)
    assert not [name for name, text in parts.items() if SECRET in text]
    assert not [name for name in parts if "signing_key" in name or "accounts" in name]
    assert "robot: Mole" in parts["configuration/site.yaml"]
    assert "signing_key: signing_key" in parts["configuration/storage.yaml"]
    assert parts["logs/run/master.log"].endswith("fine\n")
    assert REMOVED in parts["configuration/environment"]
    assert json.loads(parts[f"survey/{SURVEY}/survey.json"])["id"] == "x"
    assert '{"plan": 1}' in parts[f"survey/{SURVEY}/log.jsonl"]
    assert not [name for name in parts if "traces" in name or "latest" in name]
    assert json.loads(parts["findings.json"])["status"] == 0
    assert {one["node"] for one in json.loads(parts["diagnostics.json"])} >= {"main_control"}
    assert "python" in json.loads(parts["versions.json"])
    assert "logs/pipe.log" in missing and "logs/stolen.log" not in {*parts, *missing}
    assert f"survey/{SURVEY}/manifest.json" in missing
    for line in parts["README.txt"].splitlines()[2:10]:
        name = line.split()[0].strip(",")
        assert name in parts or any(one.startswith(name) for one in parts), name


def test_what_cannot_be_collected_has_its_reason_and_a_file_that_exists_is_kept(
    tmp_path, machine, monkeypatch
):
    refuse = mock.Mock(side_effect=OSError("it is broken"))
    with monkeypatch.context() as full, pytest.raises(OSError):
        full.setattr(bundle, "_collect", refuse)
        written(tmp_path, machine)
    assert not (tmp_path / "help.zip").exists()
    for name in ("answer_of", "end_of"):
        monkeypatch.setattr(bundle, name, refuse)
    parts, missing = written(tmp_path, machine, unheard("http://x", Evidence()))
    assert missing["system/disks.txt"] == missing["configuration/site.yaml"] == "it is broken"
    assert missing["diagnostics.json"] == "no part of the robot reports"
    assert {"README.txt", "findings.txt", "findings.json", "index.json"} <= {*parts}
    before = (tmp_path / "help.zip").read_bytes()
    with pytest.raises(FileExistsError):
        written(tmp_path, machine)
    assert (tmp_path / "help.zip").read_bytes() == before


def test_logs_have_a_limit_and_the_newest_are_taken(tmp_path, machine):
    for number in range(bundle.LOG_FILES + 5):
        path = tmp_path / f"logs/run/node-{number}.log"
        path.write_text(f"{'x' * 100}\n" * (20_000 if number == 0 else 1))
        os.utime(str(path), (2e9 + number,) * 2)
    parts, missing = written(tmp_path, machine)
    logs = [name for name in parts if name.startswith("logs/run/")]
    assert len(logs) == bundle.LOG_FILES and "logs/run/node-0.log" not in logs
    assert "older ones" in missing["logs"]
    os.utime(str(tmp_path / "logs/run/node-0.log"), (3e9, 3e9))
    (tmp_path / "help.zip").unlink()
    parts, _missing = written(tmp_path, machine)
    assert 0 < len(parts["logs/run/node-0.log"]) <= bundle.PART_BYTES


NAMES = st.sampled_from(["password", "wifi_psk", "API-KEY", "accessToken", "my_secret", "Passwd"])
NOISE = st.text(st.characters(blacklist_categories=("Cs",)), max_size=30)


@given(NAMES, st.sampled_from(["{}: {}", "{} = {}", "x {}={}", '"{}": "{}"', "{}:\n  - {}"]), NOISE)
def test_the_value_of_whatever_names_a_secret_is_removed(name, form, before):
    line = form.format(name, SECRET)
    assert SECRET not in without_secrets(f"{before}\n{line}\nafter")
    record = {"a": [{name: SECRET, "kept": before}], "b": f"{name}={SECRET}"}
    clean = json_without_secrets(json.dumps(record))
    assert SECRET not in clean
    assert "kept" in json.loads(clean)["a"][0]


FORMS = (
    'options: ["--password", "{}"] ~ - [password, {}] ~ - {{name: password, value: {}}} ~ '
    '"pass word": {} ~ {{\\"token\\": \\"{}\\"}} ~ the password is {} ~ PASSWORD {} ~ pass: {} ~ '
    "DB_PASS={} ~ user_pass: {} ~ pw={} ~ cred: {} ~ otp={} ~ snmp_community: {} ~ "
    "Set-Cookie: {} ~ curl -s -u user:{} http://a ~ sshpass -p {} ssh a ~ http://a/?sig={} ~ "
    "contrase\u00f1a: {} ~ clave={} ~ analyzer_options:\n  - {}\n ~ jwt eyJh.{}.x ~ "
    "# the wifi password of the robot in the shed is {} ~ a: 1  # {} was the password once"
)


@each_case("form", FORMS.split(" ~ "))
def test_a_secret_is_removed_however_it_is_written(tmp_path, form):
    line = form.format(SECRET)
    assert SECRET not in without_secrets(f"before\n{line}\nafter")
    (tmp_path / "a.yaml").write_bytes(f"a: 1\n{line}\n".encode("utf-16"))
    assert SECRET not in without_secrets(end_of(tmp_path / "a.yaml", 10000))


def test_a_line_of_many_letters_takes_no_minutes():
    assert without_secrets("a" * 200_000) == "a" * 200_000
