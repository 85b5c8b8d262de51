"""Repeats, once and alone, a failed test that depends on real time (marker `real_time`).

The robot's time limits are real seconds. A busy machine can break them although nothing is wrong,
so pytest-rerunfailures repeats such a test, and no other. A repeated test waits until the other
workers of pytest-xdist have finished the tests they are running, and they wait for it.
"""

from __future__ import annotations

import contextlib
import fcntl
import shutil
import tempfile
from pathlib import Path
from typing import Any, List

import pytest

MARKER = "real_time: depends on real time; repeated once, alone, if it fails"


class RunLock:
    """Lets the workers run tests side by side, and each of them one alone.

    Args:
        folder: A folder that the workers share.
    """

    def __init__(self, folder: Path) -> None:
        self._gate = (folder / "gate").open("w")
        self._running = (folder / "running").open("w")

    def acquire(self, alone: bool) -> None:
        """Wait until a test may run.

        Args:
            alone: Whether no other test may run meanwhile.
        """
        # Held until the release by who runs alone: nobody else begins while it waits.
        kind = fcntl.LOCK_EX if alone else fcntl.LOCK_SH
        fcntl.flock(self._gate, kind)
        fcntl.flock(self._running, kind)
        if not alone:
            fcntl.flock(self._gate, fcntl.LOCK_UN)

    def release(self) -> None:
        """Let others run; it is no error if nothing was acquired."""
        fcntl.flock(self._running, fcntl.LOCK_UN)
        fcntl.flock(self._gate, fcntl.LOCK_UN)


class AloneWhenRepeated:
    """The part of the plugin that runs in a worker.

    Args:
        lock: That of all workers.
    """

    def __init__(self, lock: RunLock) -> None:
        self._lock = lock

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Wait for the turn of a test."""
        # Counted by pytest-rerunfailures.
        self._lock.acquire(alone=getattr(item, "execution_count", 1) > 1)

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logfinish(self) -> None:
        """Let others run, whatever happened."""
        self._lock.release()


class SharedFolder:
    """The part of the plugin that runs in the controller of pytest-xdist."""

    def __init__(self) -> None:
        self._folder = tempfile.mkdtemp(prefix="gpr20_tests_")

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Any) -> None:
        """Name the folder to a worker."""
        node.workerinput["gpr20_folder"] = self._folder

    def pytest_unconfigure(self) -> None:
        """Remove the folder."""
        with contextlib.suppress(FileNotFoundError):
            shutil.rmtree(self._folder)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker; in parallel runs, set up the lock."""
    config.addinivalue_line("markers", MARKER)
    if hasattr(config, "workerinput"):
        lock = RunLock(Path(config.workerinput["gpr20_folder"]))
        config.pluginmanager.register(AloneWhenRepeated(lock))
    elif config.getoption("dist", "no") != "no":
        config.pluginmanager.register(SharedFolder())


def pytest_collection_modifyitems(config: pytest.Config, items: List[pytest.Item]) -> None:
    """Let pytest-rerunfailures repeat the tests that depend on real time."""
    # It refuses to work with a debugger.
    if not config.pluginmanager.hasplugin("rerunfailures") or config.option.usepdb:
        return
    for item in items:
        if item.get_closest_marker("real_time"):
            item.add_marker(pytest.mark.flaky(reruns=1))
