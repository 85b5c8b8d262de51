import sys
from pathlib import Path

import pytest
from translation_kit import shown_is_translated  # noqa: F401

# The kits of the operator's tests, and the example surveys.
for package in ("gpr20_operator", "gpr20_survey"):
    sys.path.append(str(Path(__file__).resolve().parents[3] / package / "test" / "unit"))

from operator_kit import clock, events, node, now, services, storage  # noqa: E402, F401


@pytest.fixture
def opened(application, tmp_path, clock):  # noqa: F811
    """Open windows in English, whose time only the test moves."""
    from window_helpers import close, opened_window

    windows = []

    def open_one(**parts):
        windows.append(opened_window(application, folder=tmp_path, clock=clock, **parts))
        return windows[-1]

    yield open_one
    for window in windows:
        close(window)


@pytest.fixture
def window(opened, storage, node):  # noqa: F811
    return opened(storage=storage, imaging=node)


@pytest.fixture
def finger(window, clock):  # noqa: F811
    from window_helpers import Finger

    return Finger(window, clock)
