"""What sourcing a workspace does: where ROS listens."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from case_kit import each_case

HOOKS = Path(__file__).resolve().parents[2] / "env-hooks"
ROBOT = {"GPR20_ROBOT": "10.20.0.1", "GPR20_SERVER": "10.20.0.2"}
ROS_DEFAULT = "http://localhost:11311"
ON_THE_SERVER = "http://10.20.0.2:11311"


def shell(script, environment):
    return subprocess.run(
        ["/bin/sh", "-euc", script], env=environment, capture_output=True, text=True, check=True
    )


@pytest.fixture
def sourced(tmp_path):
    """Source the hook on a machine that has these addresses."""

    def source(own_addresses, exported, before=":"):
        hostname = tmp_path / "hostname"
        hostname.write_text(f"#!/bin/sh\necho '{own_addresses} '\n")
        hostname.chmod(0o755)
        environment = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "ROS_MASTER_URI": ROS_DEFAULT}
        hook = f'HOOK="{HOOKS / "50.gpr20.sh"}"; {before}; . "$HOOK"'
        script = f'{hook}; echo "${{ROS_IP:-}}" "$ROS_MASTER_URI"'
        return shell(script, {**environment, **exported})

    return source


@each_case("name", ["ROS_IP", "ROS_HOSTNAME"])
def test_everything_is_on_loopback_and_what_opens_this_machine_otherwise_is_told(sourced, name):
    assert sourced("192.168.1.7", {}).stdout.split() == ["127.0.0.1", ROS_DEFAULT]
    assert f"{name} '192.168.1.7'" in sourced("192.168.1.7", {name: "192.168.1.7"}).stderr
    assert sourced("192.168.1.7", {name: "127.0.0.1"}).stderr == ""


@each_case("own", ["10.20.0.1", "10.20.0.2"])
def test_each_machine_listens_at_its_own_address_and_the_master_is_on_the_server(sourced, own):
    ended = sourced(f"192.168.1.7 {own}", ROBOT)
    assert ended.stdout.split() == [own, ON_THE_SERVER]
    assert ended.stderr == ""


def test_what_the_user_exported_is_kept_and_not_contradicted(sourced):
    chosen = {"ROS_IP": "10.20.0.2", "ROS_MASTER_URI": "http://10.20.0.2:11400"}
    assert sourced("", {**ROBOT, **chosen}).stdout.split() == list(chosen.values())
    ended = sourced("10.20.0.1", {**ROBOT, "ROS_HOSTNAME": "robot"})
    assert ended.stdout.split() == [ON_THE_SERVER]


@each_case(
    "robot, server",
    [
        ("10.20.0.256", "10.20.0.2"),
        ("10.20.0.1", "server"),
        ("10.20.0.01", "10.20.0.2"),
        ("10.20.0.1\n10.20.0.1", "10.20.0.2"),
        ("10.20.0.1", ""),
        ("10.20.0.1; reboot", "10.20.0.2"),
    ],
)
@each_case("exported", [{}, {"ROS_HOSTNAME": "robot"}])
def test_a_wrong_address_is_told_and_opens_nothing(sourced, exported, robot, server):
    ended = sourced("10.20.0.1", {"GPR20_ROBOT": robot, "GPR20_SERVER": server, **exported})
    assert ended.stdout.split() == ["127.0.0.1", ROS_DEFAULT]
    assert f"'{robot}'" in ended.stderr and f"'{server}'" in ended.stderr
    assert "four numbers" in ended.stderr


def test_addresses_of_other_machines_are_told_and_open_nothing(sourced):
    ended = sourced("192.168.1.7", ROBOT)
    assert ended.stdout.split()[0] == "127.0.0.1"
    assert "10.20.0.1" in ended.stderr and "192.168.1.7" in ended.stderr


def test_a_terminal_changes_between_loopback_and_two_machines(sourced, tmp_path):
    configure = "; ".join(f"export {name}={value}" for name, value in ROBOT.items())
    ended = sourced("10.20.0.1", {}, before=f'. "$HOOK"; {configure}')
    assert ended.stdout.split() == ["10.20.0.1", ON_THE_SERVER]
    ended = sourced("10.20.0.1", ROBOT, before='. "$HOOK"; unset GPR20_ROBOT GPR20_SERVER')
    assert ended.stdout.split() == ["127.0.0.1", ROS_DEFAULT]
    # An address that comes later is found when the workspace is sourced again.
    link_up = f"echo 'echo 10.20.0.2' > {tmp_path}/hostname"
    ended = sourced("192.168.1.7", ROBOT, before=f'. "$HOOK"; {link_up}')
    assert ended.stdout.split() == ["10.20.0.2", ON_THE_SERVER]
