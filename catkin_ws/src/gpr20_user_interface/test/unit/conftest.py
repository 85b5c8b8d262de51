import queue
import sys
from pathlib import Path

import pytest
from fake_clock import FakeClock
from translation_kit import shown_is_translated  # noqa: F401

# The example annotations of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def storage():
    from asked_storage import Storage

    return Storage()


@pytest.fixture
def node():
    from result_kit import Requests

    return Requests()


@pytest.fixture
def now():
    from result_kit import Now

    return Now()


@pytest.fixture
def events():
    """What clients emit."""
    return queue.Queue()


@pytest.fixture
def services(monkeypatch):
    from topics_kit import Services

    from gpr20_common.high.service_client import ServiceClient

    services = Services()
    monkeypatch.setattr(ServiceClient, "call", lambda *one, **more: services.call(*one, **more))
    yield services
    services.hung.set()


@pytest.fixture
def opened(application, tmp_path, clock):
    """Open windows in English, whose time only the test moves."""
    from window_helpers import close, opened_window

    windows = []

    def open_one(**parts):
        windows.append(opened_window(application, profiles=tmp_path, clock=clock, **parts))
        return windows[-1]

    yield open_one
    for window in windows:
        close(window)


@pytest.fixture
def window(opened, storage, node):
    return opened(storage=storage, imaging=node)


@pytest.fixture
def finger(window, clock):
    from finger import Finger

    return Finger(window, clock)
