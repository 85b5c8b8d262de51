"""One run of pytest does all tests, and leaves nothing running whatever happens."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from pytest_gpr20.rostest_items import problem
from pytest_gpr20.workspace import ROOT

pytest_plugins = ["pytester"]
LIMIT_S = 60.0
# No others, which take longer to load than the tests here.
PLUGINS = "xdist.plugin", "pytest_timeout", "pytest_gpr20.processes", "pytest_gpr20.workspace"
LOADED = [word for plugin in PLUGINS for word in ("-p", plugin)]
# In a session of its own, as what a launch starts, and soon without its parent.
LEAVE_A_PROCESS = """
    import pathlib, subprocess, time
    def test_long():
        line = "setsid sleep 600 >/dev/null 2>&1 & echo $! > pid.new; mv pid.new pid"
        subprocess.run(["bash", "-c", line])
        {then}
"""


@pytest.fixture
def own(pytester, monkeypatch):
    """Return a folder for tests that the plugins run on."""
    monkeypatch.setenv("PYTHONPATH", f"{ROOT / 'tools'}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    return pytester


def is_running(pid: Path) -> bool:
    try:
        return psutil.Process(int(pid.read_text())).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def test_a_test_that_hangs_fails_with_its_processes_and_the_others_run(own):
    own.makepyfile(
        test_hangs=LEAVE_A_PROCESS.format(then="time.sleep(600)") + "    def test_a(): pass\n",
        test_ends="def test_bad():\n    import os; os._exit(3)",
        test_b="def test_b(): pass",
    )
    limits = ["--timeout=3", "--max-worker-restart=0"]
    ended = own.runpytest_subprocess(*LOADED, "-n3", "--dist=loadfile", *limits)
    said = ended.stdout.str()
    assert "crashed while running" in said and "Timeout (>3.0s) from pytest-timeout" in said
    assert ended.ret == pytest.ExitCode.TESTS_FAILED and ended.parseoutcomes()["passed"] == 2
    assert "LEFT RUNNING" not in said and not is_running(own.path / "pid")


def test_what_a_test_leaves_running_is_ended_and_named(own):
    own.makepyfile(LEAVE_A_PROCESS.format(then=""))
    ended = own.runpytest_subprocess(*LOADED, "-n1")
    ended.stdout.fnmatch_lines(["LEFT RUNNING by a test, ended now: sleep 600"])
    assert not is_running(own.path / "pid")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_nothing_keeps_running_when_pytest_is_ended(own, number):
    own.makepyfile(LEAVE_A_PROCESS.format(then="time.sleep(600)"))
    # The shell's `&` makes it ignore Ctrl-C.
    command = [sys.executable, "-m", "pytest", *LOADED, "-n2", str(own.path)]
    line = '"$@" & echo $! > pytest.new; mv pytest.new pytest; wait $!'
    shell = subprocess.Popen(["bash", "-c", line, "bash", *command], cwd=own.path)
    pid = own.path / "pid"
    deadline_s = time.monotonic() + LIMIT_S
    while not pid.exists():
        assert time.monotonic() < deadline_s
        time.sleep(0.02)
    os.kill(int((own.path / "pytest").read_text()), number)
    assert shell.wait(LIMIT_S) == pytest.ExitCode.INTERRUPTED
    assert not is_running(pid)


@pytest.mark.parametrize(
    ("status", "printed", "found"),
    [
        (0, " * TESTS: 2\n", None),
        (0, " * TESTS: 0\n", "no test ran"),
        (0, "", "no test ran"),
        (1, "[axis/test_stop][FAILURE]\n * TESTS: 2\n", "failed: axis/test_stop"),
        (3, "", "failed: rostest ended with status 3"),
    ],
)
def test_a_rostest_passes_only_if_it_ran_tests_and_all_passed(status, printed, found):
    assert problem(status, printed) == found
