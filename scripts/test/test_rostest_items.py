"""The plugin that runs rostests as tests of pytest, on rostests made here."""

from __future__ import annotations

import os

import pytest
from pytest_gpr20.workspace import ROOT

pytest_plugins = ["pytester"]

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

    def made(body, *options, limit_s=60):
        monkeypatch.setenv("ROS_PACKAGE_PATH", f"{pytester.path}:{os.environ['ROS_PACKAGE_PATH']}")
        monkeypatch.setenv("PYTHONPATH", f"{ROOT / 'tools'}:{os.environ['PYTHONPATH']}")
        # Of a failed rostest the logs are kept.
        monkeypatch.setenv("TMPDIR", str(pytester.path))
        pytester.makeini(f"[pytest]\nrostest_limit_s = {limit_s}\n")
        (pytester.path / "package.xml").write_text(PACKAGE.strip())
        script = pytester.path / "trial.py"
        script.write_text(SCRIPT.format(body=body))
        script.chmod(0o755)
        (pytester.path / "trial.test").write_text(LAUNCH)
        plugins = "rostest_items", "abilities", "real_time"
        loaded = [word for one in plugins for word in ("-p", f"pytest_gpr20.{one}")]
        return pytester.runpytest_subprocess(*loaded, *options, "trial.test")

    return made


def test_a_rostest_has_a_master_folders_and_a_screen_of_its_own_and_passes(run, monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    names = "'ROS_HOME', 'ROS_LOG_DIR', 'ROS_TEST_RESULTS_DIR'"
    ended = run(
        "def test_own(self):\n"
        f"        folders = [os.environ[name] for name in ({names})]\n"
        "        assert all('gpr20_rostest_' in one for one in folders), folders\n"
        "        assert not os.environ['ROS_MASTER_URI'].endswith(':11311')\n"
        "        assert 'QT_QPA_PLATFORM' not in os.environ\n"
    )
    assert (ended.ret, ended.parseoutcomes()) == (0, {"passed": 1}), ended.outlines


def test_a_failure_names_the_test_shows_the_output_and_is_repeated_once(run):
    ended = run("def test_bad(self): self.fail('the reason')")
    ended.stdout.fnmatch_lines(["failed: trial.rosunit-trial/test_bad; logs are in *"])
    ended.stdout.fnmatch_lines(["*the reason*"])
    assert (ended.ret, ended.parseoutcomes()) == (1, {"failed": 1, "rerun": 1})


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
