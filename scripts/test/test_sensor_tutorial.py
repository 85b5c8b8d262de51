"""The tutorial on sensors: its files, as they are on the page, on a simulated robot."""

from __future__ import annotations

import json
import sys

import pytest
from robot_kit import LaunchedRobot, end
from tutorial_code import code_blocks
from user_shell import ROOT
from user_shell import printed_by as run
from wait_kit import wait_until

pytestmark = pytest.mark.release
PAGE = ROOT / "docs/extend/sensor.md"
LIMIT_S = 120.0
NAMES = ("soil_moisture", "soil_temperature")


@pytest.fixture
def config(tmp_path):
    """A configuration with the sensors of the page."""
    folder = tmp_path / "config"
    folder.mkdir()
    for name, text in code_blocks(PAGE, "yaml").items():
        (folder / name).write_text(text)
    return folder


def test_the_sensors_of_the_page_are_in_traces_recordings_status_and_exports(
    tmp_path, config, monkeypatch
):
    monkeypatch.setenv("ROS_MASTER_URI", "")
    robot = LaunchedRobot(tmp_path, f"config:={config}", "time_scale:=20")
    node = tmp_path / "soil_probe.py"
    node.write_text(code_blocks(PAGE, "python")[node.name])
    probe = None
    try:
        robot.start()
        probe = robot.run([sys.executable, str(node)])
        wait_for_values()
        assert robot.client("--x-points", "3", "--y-points", "3").wait(LIMIT_S) == 0
    finally:
        if probe is not None:
            end(probe, 2)
        robot.stop()
    (folder,) = (path.parent for path in robot.data.glob("*/survey.json"))
    assert_recorded(folder)
    table = tmp_path / "survey.csv"
    run("gpr20", "export", str(folder), str(table), "--format", "csv")
    assert "aux_soil_temperature [degC]" in table.read_text()


def wait_for_values():
    """Return when /diagnostics, and so STATUS, shows a value of each sensor."""
    for name in NAMES:

        def shown(wanted=f"sensors/{name}: value"):
            said = run("rostopic", "echo", "-n", "8", "/diagnostics").split("level: ")
            return any(one.startswith("0") and wanted in one for one in said)

        wait_until(shown, limit_s=LIMIT_S)


def assert_recorded(folder):
    traces = [json.loads(path.read_text()) for path in sorted((folder / "traces").iterdir())]
    assert len(traces) == 18
    for trace in traces:
        # The temperature of the VNA is among them too.
        moisture, temperature = (one for one in trace["aux"] if one["name"] in NAMES)
        assert (moisture["name"], moisture["unit"]) == ("soil_moisture", "m3/m3")
        assert 0.2 <= moisture["value"] <= 0.3
        assert (temperature["name"], temperature["value"]) == ("soil_temperature", 18.5)
        assert moisture["stamp"] <= trace["timestamp"]
        assert trace["quality"] == []
    assert len({trace["aux"][0]["value"] for trace in traces}) > 1
    described = json.loads((folder / "survey.json").read_text())
    assert [one["name"] for one in described["sensors"]] == list(NAMES)
    assert "complete and intact" in run("gpr20", "verify", str(folder))
