"""Ends a worker of pytest-xdist whose test hangs; the test has failed, and the run continues."""

from __future__ import annotations

import faulthandler
import os
import threading
from typing import Optional

import pytest

from pytest_gpr20.processes import end_descendants

# More than the limits that the tests set themselves.
LIMIT_S = 1200.0
SETTING = "test_limit_s"


class TimeLimit:
    """The limit of each test of a worker.

    Args:
        limit_s: After this many seconds a test is ended, with the worker and its descendants.
    """

    def __init__(self, limit_s: float) -> None:
        self._limit_s = limit_s
        # While a test runs its stderr is captured.
        self._stderr = os.dup(2)
        self._timer: Optional[threading.Timer] = None
        self._exceeded = False

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Start the clock of a test."""
        self._stop()
        self._timer = threading.Timer(self._limit_s, self._end, [item.nodeid])
        self._timer.daemon = True
        self._timer.start()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(self) -> None:
        """Let a test that is being ended report nothing: what it waited for has been killed."""
        if self._exceeded:
            threading.Event().wait()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logfinish(self) -> None:
        """Stop the clock, whatever happened."""
        self._stop()

    def _stop(self) -> None:
        if self._timer:
            self._timer.cancel()

    def _end(self, name: str) -> None:
        self._exceeded = True
        text = f"\n{name} hangs: ended after the limit of {self._limit_s:g} s\n"
        os.write(self._stderr, text.encode())
        faulthandler.dump_traceback(self._stderr)
        end_descendants(os.getpid(), and_itself=False)
        os._exit(1)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the limit."""
    parser.addini(SETTING, "time limit of a test in a worker [s]", default=str(LIMIT_S))


def pytest_configure(config: pytest.Config) -> None:
    """Limit the tests of a worker; a developer may look at one test in a debugger."""
    if hasattr(config, "workerinput"):
        config.pluginmanager.register(TimeLimit(float(config.getini(SETTING))))
