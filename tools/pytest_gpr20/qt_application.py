"""One application of Qt for all tests of a process, on a screen that nobody sees.

Qt allows one in the life of a process: a second one, or a widget that outlives the first, corrupts
memory, and a later test of a window crashes.
"""

from __future__ import annotations

import os
from typing import Any, Iterator

import pytest


@pytest.fixture(scope="session")
def application() -> Iterator[Any]:
    """The application, until the process ends."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PyQt5.QtWidgets import QApplication

    yield QApplication.instance() or QApplication(["test"])
