"""The plugin that runs rostests as tests of pytest, on rostests made here."""

from __future__ import annotations

import os

import pytest
from pytest_gpr20.workspace import ROOT

pytest_plugins = ["pytester"]
pytestmark = pytest.mark.real_time

PACKAGE = """
<package format="2"><name>trial</name><version>0.1.0</version><description>trial</description>
<maintainer email="nobody@example.com">nobody</maintainer><license>none</license></package>
"""
LAUNCH = '<launch><test test-name="trial" pkg="trial" type="trial.py" time-limit="60"/></launch>'
SCRIPT = """#!/usr/bin/env python3
import os, time, unittest, rosunit
class Trial(unittest.TestCase):
    {body}
rosunit.unitrun("trial", "trial", Trial)
"""


@pytest.fixture
def run(pytester, monkeypatch):
    """Run a rostest whose test case has this body; return how pytest ended."""

    def made(body, *options, limit_s=60, launch=LAUNCH):
        monkeypatch.setenv("ROS_PACKAGE_PATH", f"{pytester.path}:{os.environ['ROS_PACKAGE_PATH']}")
        monkeypatch.setenv("PYTHONPATH", f"{ROOT / 'tools'}:{os.environ['PYTHONPATH']}")
        # Of a failed rostest the logs are kept.
        monkeypatch.setenv("TMPDIR", str(pytester.path))
        pytester.makeini(f"[pytest]\nrostest_limit_s = {limit_s}\n")
        (pytester.path / "package.xml").write_text(PACKAGE.strip())
        script = pytester.path / "trial.py"
        script.write_text(SCRIPT.format(body=body))
        script.chmod(0o755)
        (pytester.path / "trial.test").write_text(launch)
        plugins = "last_line", "rostest_items", "abilities", "real_time"
        loaded = [word for one in plugins for word in ("-p", f"pytest_gpr20.{one}")]
        return pytester.runpytest_subprocess(*loaded, *options, "trial.test")

    return made


def test_a_rostest_that_passes_passes(run):
    ended = run("def test_good(self): pass")
    ended.stdout.fnmatch_lines(["* s  trial.test::rostest: 1 tests"])
    assert (ended.ret, ended.outlines[-1]) == (0, "1 passed, 0 failed, 0 skipped, 0 rerun")


def test_a_rostest_that_needs_what_the_machine_does_not_allow_is_skipped(
    run, pytester, monkeypatch
):
    pytester.makefile("", mount="#!/bin/sh\necho must be superuser >&2\nexit 1")
    (pytester.path / "mount").chmod(0o755)
    monkeypatch.setenv("PATH", f"{pytester.path}:{os.environ['PATH']}")
    launch = LAUNCH.replace("<launch>", '<launch><arg name="needs" value="mounts"/>')
    ended = run("def test_not_run(self): self.fail()", launch=launch)
    reason = "no mounts here: must be superuser"
    assert ended.outlines[-1] == f"0 passed, 0 failed, 1 skipped (1 x {reason}), 0 rerun"


def test_a_rostest_chooses_its_screen_itself(run, monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    ended = run("def test_screen(self): self.assertNotIn('QT_QPA_PLATFORM', os.environ)")
    assert ended.ret == 0


def test_a_failure_names_the_test_and_shows_the_output_and_is_repeated_once(run):
    ended = run("def test_bad(self): self.fail('the reason')")
    ended.stdout.fnmatch_lines(["failed: trial.rosunit-trial/test_bad; logs are in *"])
    ended.stdout.fnmatch_lines(["*the reason*"])
    assert ended.ret == 1
    counted = "0 passed, 1 failed, 0 skipped, 1 rerun (1 x trial.test::rostest)"
    assert ended.outlines[-1] == counted


def test_a_rostest_that_passes_when_it_is_repeated_is_counted_as_such(run, pytester):
    seen = pytester.path / "seen"
    body = (
        f"def test_second(self): os.path.exists({str(seen)!r}) or (open({str(seen)!r}, 'w'), 1/0)"
    )
    ended = run(body)
    counted = "1 passed, 0 failed, 0 skipped, 1 rerun (1 x trial.test::rostest)"
    assert ended.stdout.str().count("trial.test::rostest: 1 tests") == 1
    assert (ended.ret, ended.outlines[-1]) == (0, counted)


def test_a_rostest_without_tests_fails(run):
    ended = run("pass", "-p", "no:rerunfailures")
    ended.stdout.fnmatch_lines(["no test ran; *"])
    assert ended.ret == 1


def test_a_rostest_that_hangs_is_ended_with_its_processes(run, pytester):
    pid = pytester.path / "pid"
    body = f"def test_hangs(self): open({str(pid)!r}, 'w').write(str(os.getpid())), time.sleep(600)"
    ended = run(body, "-p", "no:rerunfailures", limit_s=8)
    ended.stdout.fnmatch_lines(["the time limit ended it; *"])
    assert ended.ret == 1
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)


def test_every_rostest_has_a_master_and_folders_of_its_own(run):
    names = "'ROS_HOME', 'ROS_LOG_DIR', 'ROS_TEST_RESULTS_DIR'"
    ended = run(
        "def test_own(self):\n"
        f"        folders = [os.environ[name] for name in ({names})]\n"
        "        assert all('gpr20_rostest_' in one for one in folders), folders\n"
        "        assert not os.environ['ROS_MASTER_URI'].endswith(':11311')\n"
    )
    assert ended.ret == 0, ended.outlines
