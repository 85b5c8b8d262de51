"""Ends, with a test or with the whole run, every process that the tests have started.

A process is known by a variable of its environment: what a launch starts is in sessions of its own,
and a child of init when its parent was killed.
"""

from __future__ import annotations

import contextlib
import os
import time
from typing import Any, Dict, List

import psutil
import pytest

VARIABLE = "STARTED_BY_TESTS"
# Longer than roslaunch takes to end its nodes.
END_LIMIT_S = 20.0
POLL_S = 0.05
NAMES: pytest.StashKey[List[str]] = pytest.StashKey()


def end_processes(mark: str) -> List[str]:
    """End other processes, gently first; return their names.

    Args:
        mark: How the variable of their environment begins.
    """
    found: Dict[psutil.Process, str] = {}
    for process in psutil.process_iter():
        # It has ended meanwhile, or it is somebody else's.
        with contextlib.suppress(psutil.Error):
            marked = process.environ().get(VARIABLE, "").startswith(mark)
            if marked and process.pid != os.getpid():
                found[process] = " ".join(process.cmdline())
                process.terminate()
    deadline_s = time.monotonic() + END_LIMIT_S
    while any(map(_runs, found)):
        for process in found if time.monotonic() > deadline_s else ():
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()
        time.sleep(POLL_S)
    return list(found.values())


def _runs(process: psutil.Process) -> bool:
    """Return whether a process runs: the orphans of a container may stay zombies."""
    try:
        return process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Mark what this process will start; a worker's mark begins with that of the whole run."""
    run = getattr(config, "workerinput", {}).get("gpr20_mark", "")
    os.environ[VARIABLE] = f"{run}{os.getpid()}."


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Give a worker the mark of the run."""
    node.workerinput["gpr20_mark"] = os.environ[VARIABLE]


def pytest_exception_interact(call: Any) -> None:
    """End what a test has started that came to its time limit."""
    if "from pytest-timeout" in str(call.excinfo.value):
        end_processes(os.environ[VARIABLE])


def pytest_keyboard_interrupt() -> None:
    """End the workers too: pytest-xdist would kill them and nobody else."""
    end_processes(os.environ[VARIABLE])


def pytest_sessionfinish(session: pytest.Session) -> None:
    """End what the tests left running."""
    if not hasattr(session.config, "workerinput"):
        names = end_processes(os.environ[VARIABLE])
        # Python's own, which ends after the process whose resources it watches.
        left = [one for one in names if "resource_tracker" not in one]
        session.config.stash[NAMES] = left


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say what they left running."""
    for name in config.stash.get(NAMES, []):
        terminalreporter.write_line(f"LEFT RUNNING by a test, ended now: {name}")
