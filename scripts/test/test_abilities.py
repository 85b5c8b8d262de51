"""The plugin that skips tests of what a machine does not allow, on tests made here."""

from __future__ import annotations

import os

import pytest
from pytest_gpr20.workspace import ROOT

pytest_plugins = ["pytester"]

TEST = """
import pytest

@pytest.mark.needs({ability!r})
def test_once(): pass

@pytest.mark.needs({ability!r})
def test_twice(): pass
"""
# What iproute2 prints in a chroot: its root is no mount point.
FAILING = """#!/bin/sh
echo "$@" >>"{calls}"
echo '{said}' >&2
echo '       dmesg(1) may have more information.' >&2
exit 1
"""


@pytest.fixture
def run(pytester, monkeypatch):
    """Run two tests that need an ability; return how pytest ended."""

    def made(ability):
        monkeypatch.setenv("PYTHONPATH", f"{ROOT / 'tools'}:{os.environ['PYTHONPATH']}")
        pytester.makepyfile(TEST.format(ability=ability))
        loaded = ["-p", "pytest_gpr20.abilities", "-p", "pytest_gpr20.last_line"]
        return pytester.runpytest_subprocess(*loaded)

    return made


@pytest.mark.parametrize(
    ("ability", "program", "said"),
    [
        ("network namespaces", "ip", "mount --make-rslave /: Invalid argument"),
        ("firewall", "ip", "mkdir /run/netns failed: Permission denied"),
        ("mounts", "mount", "mount: must be superuser to use mount."),
    ],
)
def test_what_is_not_allowed_is_tried_once_and_the_reason_is_in_the_last_line(
    ability, program, said, run, tmp_path, monkeypatch
):
    calls = tmp_path / "calls"
    (tmp_path / program).write_text(FAILING.format(calls=calls, said=said))
    (tmp_path / program).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    ended = run(ability)
    reason = f"no {ability} here: {said}"
    assert ended.outlines[-1] == f"0 passed, 0 failed, 2 skipped (2 x {reason}), 0 rerun"
    assert len(calls.read_text().splitlines()) == 1


def test_the_last_line_is_one_line_whatever_the_reason_is(pytester, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", f"{ROOT / 'tools'}:{os.environ['PYTHONPATH']}")
    pytester.makepyfile("import pytest\ndef test_no(): pytest.skip('not\\n    here')")
    ended = pytester.runpytest_subprocess("-p", "pytest_gpr20.last_line")
    assert ended.outlines[-1] == "0 passed, 0 failed, 1 skipped (1 x not here), 0 rerun"


def test_a_missing_program_is_a_reason(run, tmp_path, monkeypatch):
    python = tmp_path / "python3"
    python.symlink_to(os.path.realpath("/usr/bin/python3"))
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "no mounts here: mount: No such file or directory" in run("mounts").outlines[-1]


# As for a container or an ordinary user.
REFUSING = """
import errno, socket

class Refusing(socket.socket):
    def setsockopt(self, level, option, value):
        if option == 26:
            raise PermissionError(errno.EPERM, "Operation not permitted")
        super().setsockopt(level, option, value)

socket.socket = Refusing
"""


def test_where_no_socket_filter_can_be_set_only_tests_that_need_one_are_skipped(
    pytester, monkeypatch
):
    pytester.makepyfile(sitecustomize=REFUSING)
    monkeypatch.setenv("PYTHONPATH", f"{pytester.path}:{os.environ['PYTHONPATH']}")
    packages = ROOT / "catkin_ws/src"
    tests = [
        packages / "gpr20_common/test/unit/test_tcp_keepalive.py",
        packages / "gpr20_axis_driver/test/ros/axis_unplugged.test",
    ]
    ended = pytester.runpytest_subprocess(f"--rootdir={ROOT}", f"-c{ROOT}/pyproject.toml", *tests)
    reason = "2 x no socket filters here: SO_ATTACH_FILTER: Operation not permitted"
    assert ended.outlines[-1] == f"2 passed, 0 failed, 2 skipped ({reason}), 0 rerun"
