import os
import sys
from pathlib import Path

import pytest
from fake_clock import FakeClock

# The example annotations of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))


@pytest.fixture(scope="session", autouse=True)
def one_qt_application():
    """Keep the first application for all modules: Qt does not survive a second one."""
    try:
        from PyQt5.QtWidgets import QApplication
    except ImportError:
        yield None
        return
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    application = QApplication.instance() or QApplication([])
    yield application


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()
