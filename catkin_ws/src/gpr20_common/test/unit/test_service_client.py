"""Service calls over real sockets: answered, too late, given up, and their late delivery."""

import socket
import threading
import time

import pytest

pytest.importorskip("rospy")
pytest.importorskip("gpr20_msgs.srv")

from rosgraph.network import encode_ros_handshake_header

from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_msgs.srv import Command

pytestmark = pytest.mark.real_time

LIMIT_S = 20.0
SHORT_S = 0.3


class Service:
    """A node that offers one service and may hang."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.uri = f"rosrpc://127.0.0.1:{self.listener.getsockname()[1]}"
        self.answer_header = True
        self.received = []
        self.ended = threading.Event()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        connection, _address = self.listener.accept()
        with connection:
            connection.settimeout(LIMIT_S)
            try:
                self.received.append(connection.recv(4096))
                if self.answer_header:
                    fields = {"md5sum": Command._md5sum, "type": Command._type}
                    connection.sendall(encode_ros_handshake_header(fields))
                while self.received[-1]:
                    self.received.append(connection.recv(4096))
            except OSError:
                self.received.append(b"")
        self.ended.set()


@pytest.fixture
def service(monkeypatch):
    service = Service()
    monkeypatch.setattr(ServiceClient, "_look_up", lambda _client, _attempt: service.uri)
    yield service
    service.listener.close()


def test_a_call_that_is_not_answered_in_time_ends_and_so_does_its_connection(service):
    client = ServiceClient("stop", Command)
    begun_s = time.monotonic()
    with pytest.raises(ServiceUnavailableError, match=r"did not answer within 0\.3 s"):
        client.call(SHORT_S)
    assert time.monotonic() - begun_s < LIMIT_S
    assert service.ended.wait(LIMIT_S)


def test_a_call_that_is_given_up_before_it_is_connected_is_never_made(service):
    service.answer_header = False
    client = ServiceClient("homing", Command)
    with pytest.raises(ServiceUnavailableError):
        client.call(SHORT_S)
    assert service.ended.wait(LIMIT_S)
    # The header alone: no request came after it.
    header, end = service.received
    assert b"homing" in header
    assert end == b""


def test_a_call_whose_delivery_counts_more_than_its_answer_is_not_given_up(service):
    client = ServiceClient("stop_survey", Command, discard_late=False)
    with pytest.raises(ServiceUnavailableError):
        client.call(SHORT_S)
    assert not service.ended.wait(SHORT_S)
    service.listener.close()


def test_a_service_that_refuses_connections_is_told_within_the_limit(service):
    service.listener.close()
    begun_s = time.monotonic()
    with pytest.raises(ServiceUnavailableError, match="could not be called|did not answer"):
        ServiceClient("get_height", Command).call(SHORT_S)
    assert time.monotonic() - begun_s < LIMIT_S
