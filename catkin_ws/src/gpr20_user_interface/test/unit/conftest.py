import os
import sys
import threading
from pathlib import Path

import pytest

# The example annotations of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))


class FakeClock:
    """A clock that only the test moves."""

    def __init__(self) -> None:
        self._now_s = 1000.0

    def now_s(self) -> float:
        return self._now_s

    def advance(self, seconds: float) -> None:
        self._now_s += seconds

    def sleep_until_s(self, deadline_s: float) -> None:
        self._now_s = max(self._now_s, deadline_s)

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        self._now_s += timeout_s
        return event.is_set()


@pytest.fixture(scope="session", autouse=True)
def one_qt_application():
    """Keep the first application for all modules: Qt does not survive a second one."""
    try:
        from PyQt5.QtWidgets import QApplication
    except ImportError:
        yield None
        return
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    yield QApplication.instance() or QApplication([])


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()
