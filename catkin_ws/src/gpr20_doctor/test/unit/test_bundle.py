"""The bundle for remote help: what is in it, and that nothing else ever is."""

import json
import os
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_robot_checks import report

from gpr20_common.faults import CONFIGURATION, DISK_FULL
from gpr20_common.message import Message
from gpr20_doctor.mid import bundle
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine import Machine
from gpr20_survey.folder.log_record import Kind, LogRecord

SECRET = "hunt@er2:h9ter"
SERVICE = f"ntfys://kim:{SECRET}@ntfy.example/mines-7f3"
SURVEY = "20260731T101500_0f8fad5b"
LOG = f"""[rosout][INFO] 2026-11-30 12:11:50,361: password {SECRET}
[rosout][ERROR] 2026-11-30 12:11:51,000: {SERVICE} does not answer {SECRET}
Traceback (most recent call last):
  File "/opt/{SECRET}/gpr20_web/low/logins.py", line 12, in send
    connect("{SECRET}")
ConnectionError: {SERVICE}
[rosout][WARN] 2026-11-30 12:11:52,000: store_data refused: the disk is full ({SECRET})
[robot/web-7] process has died [pid 12, exit code -9, cmd web --password {SECRET}].
"""


@pytest.fixture
def machine(tmp_path):
    """A robot's computer with one survey, logs, and secrets wherever they could lie."""
    record = LogRecord.after(None, Kind.PAUSE, {"note": SECRET}, "2026-07-31T10:15:00Z")
    fault = record.line().decode().replace(f'"{SECRET}"', f'{{"code":"disk.full","a":"{SECRET}"}}')
    files = {
        "robot/site.yaml": f"robot: {SECRET}\nwifi_password: {SECRET}\noperator: Kim\n",
        "robot/axes.yaml": f"x: {{dir_pin: 13, type: LIN, controller_options: [{SECRET}]}}\n",
        "robot/web.yaml": f"port: 8080\nfolder: /srv/{SECRET}\n",
        "robot/height.yaml": "a: [\n",
        "robot/wiring.yaml": f"unchecked: [pins, '{SECRET}', directions]\n",
        "robot/signing_key": SECRET,
        "logs/run/web.log": LOG,
        "logs/run/quiet.log": LOG.splitlines()[0],
        f"data/{SURVEY}/log.jsonl": fault,
        f"data/{SURVEY}/traces/000001.json": "a trace",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    os.mkfifo(str(tmp_path / "logs/pipe.log"))
    environment = {
        "GPR20_DATA": str(tmp_path / "data"),
        "ROS_LOG_DIR": str(tmp_path / "logs"),
        "GPR20_TOKEN": SECRET,
    }
    return Machine.here(environment, tmp_path, tmp_path / "robot")


def written(tmp_path, machine, robot, *more):
    """Return the parts of a bundle, by their names."""
    with mock.patch("os.nice"):  # a process cannot take its niceness back
        found = (*findings(robot, None), *more)
        bundle.write_bundle(tmp_path / "help.json", found, robot, machine)
    return json.loads((tmp_path / "help.json").read_text())


SAYS = Message(
    "{name}: {state}",
    name=Message(SECRET),
    state=Message("the disk is full", details=SECRET).with_fault(DISK_FULL),
)


PLACE = Message("{place}: {reason}", place=f"/{SECRET}/axes.yaml: x/dir_pin is 28", reason=SECRET)
WRONG = Finding.of("config_files", PLACE, CONFIGURATION)


def test_it_holds_what_helps_and_no_secret_however_that_is_written(tmp_path, machine):
    robot = report(
        "vna_processing",
        2,
        SAYS,
        token=SECRET,
        service=SERVICE,
        stored="12",
        address="192.0.2.7",
    )
    parts = written(tmp_path, machine, robot, WRONG)
    whole = (tmp_path / "help.json").read_text()
    for words in ("hunt", "er2", "h9ter", "ntfy", "mines-", "Kim", "a trace", "192.0"):
        assert words not in whole, words
    assert str(tmp_path) not in whole
    (said,) = [one for one in parts["diagnostics"] if one["level"] == "ERROR"]
    assert said["name"] == "vna_processing" and said["numbers"] == {"stored": "12"}
    assert said["code"] == "disk.full" and "the disk is full" in said["said"]
    assert parts["findings"][-1]["places"] == ["axes.yaml", "x/dir_pin is 28"]
    assert parts["wiring.yaml"] == {"unchecked": ["pins", "directions"]}
    assert parts["axes.yaml"] == {"x": {"dir_pin": 13, "type": "LIN"}}
    assert parts["web.yaml"] == {"port": 8080}
    assert '"kind":"pause"' in parts["survey"] and '"code":"disk.full"' in parts["survey"]
    # Nothing went wrong in the other one.
    (log,) = [text for name, text in parts.items() if name.startswith("log ")]
    assert log == [
        "[rosout][ERROR] 2026-11-30 12:11:51,000",
        'gpr20_web/low/logins.py", line 12, in send',
        "ConnectionError",
        "[rosout][WARN] 2026-11-30 12:11:52,000",
        "the disk is full",
        "[robot/web-7] process has died [pid 12, exit code -9",
    ]
    # One that cannot be read; what is not there has the defaults.
    assert list(parts["missing"]) == ["height.yaml"]


NAMES = st.sampled_from([*sorted(bundle.KEYS), "password", SECRET])
VALUES = st.recursive(
    st.just(SECRET) | st.integers(0, 9),
    lambda inner: st.lists(inner) | st.dictionaries(NAMES, inner),
)


@given(VALUES, st.text(), st.sampled_from(["{}", "{}={}", "[a][ERROR] {}: {}", 'File "{}", {}']))
def test_a_secret_leaves_by_no_value_and_no_line(value, text, form):
    assert SECRET not in json.dumps(bundle.listed(value))
    line = form.replace("{}", text, 1).replace("{}", SECRET)
    for pattern in (bundle.LOG_WORDS, bundle.FACT_WORDS):
        assert not any(SECRET in one.group() for one in pattern.finditer(f"{line}\n{SECRET}"))


def test_a_bundle_that_cannot_be_written_leaves_nothing_and_replaces_nothing(tmp_path, machine):
    refuse = mock.Mock(side_effect=MemoryError)
    with mock.patch.object(bundle, "_versions", refuse), pytest.raises(MemoryError):
        written(tmp_path, machine, report("web"))
    assert not (tmp_path / "help.json").exists()
    (tmp_path / "help.json").write_text("mine")
    with pytest.raises(FileExistsError):
        written(tmp_path, machine, report("web"))
    assert (tmp_path / "help.json").read_text() == "mine"
