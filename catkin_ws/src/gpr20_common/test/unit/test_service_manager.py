"""What systemd hears from a service."""

import socket

import pytest
from case_kit import each_case

from gpr20_common.low.service_manager import ServiceManager


@pytest.fixture(params=["path", "abstract"])
def manager(request, tmp_path):
    """Return systemd's socket and the address that it gives to its services."""
    name = str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.settimeout(5.0)
        listener.bind(name if request.param == "path" else "\0" + name[1:])
        yield listener, name if request.param == "path" else "@" + name[1:]


def test_a_service_says_that_it_works_and_for_how_long(manager):
    listener, address = manager
    service = ServiceManager({"NOTIFY_SOCKET": address})
    service.keep_alive(60.0)
    assert listener.recv(200).split(b"\n") == [b"WATCHDOG=1", b"WATCHDOG_USEC=60000000"]
    service.release()
    assert listener.recv(200) == b"WATCHDOG_USEC=0"


@each_case("environment", [{}, {"NOTIFY_SOCKET": ""}, {"NOTIFY_SOCKET": "/nowhere/notify"}])
def test_without_systemd_nothing_is_sent(manager, environment):
    listener, _address = manager
    ServiceManager(environment).keep_alive(60.0)
    listener.setblocking(False)
    with pytest.raises(BlockingIOError):
        listener.recv(200)


def test_a_systemd_that_reads_nothing_does_not_hold_up_a_service(manager):
    listener, address = manager
    service = ServiceManager({"NOTIFY_SOCKET": address})
    for _ in range(5000):
        service.keep_alive(60.0)
    assert listener.recv(200).startswith(b"WATCHDOG=1")
