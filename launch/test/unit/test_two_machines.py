"""Where ROS listens after the workspace was sourced."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

HOOK = Path(__file__).resolve().parents[2] / "env-hooks" / "50.gpr20.sh"
ROBOT = {"GPR20_ROBOT": "10.20.0.1", "GPR20_SERVER": "10.20.0.2"}
ROS_DEFAULT = "http://localhost:11311"


@pytest.fixture
def sourced(tmp_path):
    """Source the hook on a machine that has these addresses."""

    def source(own_addresses, exported):
        hostname = tmp_path / "hostname"
        hostname.write_text(f"#!/bin/sh\necho '{own_addresses} '\n")
        hostname.chmod(0o755)
        environment = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "ROS_MASTER_URI": ROS_DEFAULT}
        return subprocess.run(
            ["sh", "-euc", f'. "{HOOK}"; echo "$ROS_IP" "$ROS_MASTER_URI"'],
            env={**environment, **exported},
            capture_output=True,
            text=True,
            check=True,
        )

    return source


def test_without_other_words_everything_is_on_loopback(sourced):
    assert sourced("192.168.1.7", {}).stdout.split() == ["127.0.0.1", ROS_DEFAULT]


@pytest.mark.parametrize("own", ["10.20.0.1", "10.20.0.2"])
def test_each_machine_listens_at_its_own_address_and_the_master_is_on_the_server(sourced, own):
    ended = sourced(f"192.168.1.7 {own}", ROBOT)
    assert ended.stdout.split() == [own, "http://10.20.0.2:11311"]
    assert ended.stderr == ""


def test_what_the_user_exported_is_kept(sourced):
    chosen = {"ROS_IP": "10.20.0.2", "ROS_MASTER_URI": "http://10.20.0.2:11400"}
    ended = sourced("", {**ROBOT, **chosen})
    assert ended.stdout.split() == list(chosen.values())


@pytest.mark.parametrize(
    ("robot", "server"),
    [
        ("10.20.0", "10.20.0.2"),
        ("10.20.0.256", "10.20.0.2"),
        ("10.20.0.1", "server"),
        ("10.20.0.1", "10.20.0.2.3"),
        ("10.20.0.1", ""),
        ("10.20.0.1; reboot", "10.20.0.2"),
    ],
)
def test_a_wrong_address_is_told_and_opens_nothing(sourced, robot, server):
    ended = sourced("10.20.0.1", {"GPR20_ROBOT": robot, "GPR20_SERVER": server})
    assert ended.stdout.split() == ["127.0.0.1", ROS_DEFAULT]
    assert f"'{robot}'" in ended.stderr
    assert f"'{server}'" in ended.stderr
    assert "four numbers" in ended.stderr


def test_addresses_of_other_machines_are_told_and_open_nothing(sourced):
    ended = sourced("192.168.1.7", ROBOT)
    assert ended.stdout.split()[0] == "127.0.0.1"
    assert "10.20.0.1" in ended.stderr
    assert "192.168.1.7" in ended.stderr
