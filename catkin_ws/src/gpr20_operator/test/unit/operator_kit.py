"""Fixtures of the tests of every screen: time, storage and imaging that answer when a test says."""

import queue

import pytest
from asked_storage import Storage
from fake_clock import FakeClock
from result_kit import Now, Requests


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
def storage():
    return Storage()


@pytest.fixture
def node():
    return Requests()


@pytest.fixture
def now():
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
