"""The commands of the README, as a user runs them."""

from __future__ import annotations

import contextlib
import ipaddress
import json
import os
import re
import signal
import subprocess

import psutil
import pytest
from robot_kit import free_port
from user_shell import LIMIT_S, NODES, ROOT, printed_by, user_environment
from wait_kit import wait_until

pytestmark = pytest.mark.timeout(900)
TRACES = 7 * 7 * 2
# It lasts longer than a look at all of its processes takes.
SMALL = ["--x-points", "6", "--y-points", "6"]  # 72 traces
# A target is found if its candidate is this close [mm]; its depth is exact to the resolution.
NEAR_MM, NEAR_DEPTH_MM = 10.0, 5.0
PLACE = r"x (\d+), y (\d+), depth (\d+)"


def fenced_lines(text):
    """Return the lines inside fences, in order."""
    blocks = re.findall(r"^```[a-z]*\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines()]


def processes_about(text):
    """Return the command lines of the processes that mention a text."""
    listed = subprocess.run(["pgrep", "-af", text], capture_output=True, text=True, check=False)
    return listed.stdout.splitlines()


@pytest.fixture(scope="module")
def whole_survey(tmp_path_factory):
    """A survey made by the first command: (what was printed, its folder).

    In a clean clone, on a bare machine, scripts/bare_debian.sh runs it.
    """
    temporary = tmp_path_factory.mktemp("temporary")
    data = tmp_path_factory.mktemp("data")
    command = fenced_lines((ROOT / "README.md").read_text())[0]
    printed = printed_by(command, folder=ROOT, env=user_environment(data, TMPDIR=str(temporary)))
    assert not list(temporary.iterdir())
    (folder,) = (one for one in data.iterdir() if one.is_dir())
    return printed, folder


def test_the_first_command_runs_a_survey_to_its_end_and_reports_that_it_is_simulated(whole_survey):
    printed, folder = whole_survey
    assert len(list((folder / "traces").glob("*.json"))) == TRACES
    metadata = json.loads((folder / "survey.json").read_text())
    assert (metadata["outcome"], metadata["stored_traces"]) == ("finished", TRACES)
    for path in (folder / "traces", folder / "survey.bag", folder / "survey.mcap"):
        assert str(path) in printed
    assert f"rosbag play --prefix=/replay {folder}/survey.bag" in printed
    report = folder.with_name(f"{folder.name}.html")
    assert f"file://{report}" in printed.split("Check it")[1]
    text = report.read_text(encoding="utf-8")
    assert "SIMULATED" in printed and "SIMULATED" in text and "Maximum projections, 0°" in text
    # Nothing of it runs.
    assert processes_about(str(folder.parent)) == []


def listening_addresses(process):
    """Return the addresses at which a program and all that it has started can be reached."""
    found = []
    for one in (process, *process.children(recursive=True)):
        with contextlib.suppress(psutil.NoSuchProcess, psutil.ZombieProcess):
            found += [
                each.laddr.ip
                for each in one.net_connections(kind="inet")
                if each.status in (psutil.CONN_LISTEN, psutil.CONN_NONE) and each.laddr
            ]
    return found


def printed_lines(printed, begin, end):
    """Return the indented lines between two headings."""
    return [line.strip() for line in printed.split(begin)[1].split(end)[0].splitlines()[1:]]


def test_what_it_says_of_replaying_and_checking_works_as_printed(whole_survey, tmp_path):
    printed, _folder = whole_survey
    # Somebody else may use the master of this computer.
    own_master = f"export ROS_MASTER_URI=http://localhost:{free_port()}"
    lines = [own_master, *printed_lines(printed, "Replay it", "or with ROS's own")]
    for commands, said in (
        (lines, f"{TRACES} traces were published"),
        (
            printed_lines(printed, "Check it", "\n\nThe report"),
            f"complete and intact: all {TRACES} planned traces",
        ),
    ):
        script = ("bash", "-c", "\n".join(commands))
        assert said in printed_by(*script, folder=tmp_path, env=user_environment(tmp_path))


def test_its_image_shows_the_targets_of_the_scene_where_they_are(whole_survey):
    printed, _folder = whole_survey
    found = re.findall(rf"^  (.*\S) +{PLACE} +{PLACE}$", printed, re.MULTILINE)
    assert [name for name, *_numbers in found] == ["metallic sphere", "plastic disc"]
    for _name, *numbers in found:
        buried, shown = [int(one) for one in numbers[:3]], [int(one) for one in numbers[3:]]
        assert buried[:2] == pytest.approx(shown[:2], abs=NEAR_MM)
        assert buried[2] == pytest.approx(shown[2], abs=NEAR_DEPTH_MM)


def test_nobody_else_reaches_a_survey_and_ctrl_c_stops_it_cleanly_to_be_resumed(tmp_path):
    # As a terminal does: the signal goes to the whole foreground group.
    process = subprocess.Popen(
        [str(ROOT / "scripts/survey.sh"), *SMALL],
        env=user_environment(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    wait_until(lambda: any(tmp_path.glob("*/traces/*.json")), alive=[process])
    addresses = listening_addresses(psutil.Process(process.pid))
    # A node of ROS has two servers, one for calls and one for topics.
    assert len(addresses) >= 2 * len(NODES)
    assert all(ipaddress.ip_address(one).is_loopback for one in addresses), addresses
    os.killpg(process.pid, signal.SIGINT)
    printed, _nothing = process.communicate(timeout=LIMIT_S)
    assert process.returncode == 130, printed
    (survey,) = tmp_path.glob("*/survey.json")
    metadata = json.loads(survey.read_text())
    assert metadata["outcome"] == "stopped"
    assert metadata["stored_traces"] == len(list(survey.parent.glob("traces/*.json")))
    assert processes_about(str(tmp_path)) == []

    resume = (ROOT / "scripts/survey.sh", "--resume", survey.parent)
    printed_by(*resume, env=user_environment(tmp_path))
    assert json.loads(survey.read_text())["stored_traces"] == 72
