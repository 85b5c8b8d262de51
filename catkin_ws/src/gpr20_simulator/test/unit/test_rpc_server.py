from __future__ import annotations

import contextlib
import os
import select
import socket

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from rpc_wire import LAST, RawClient, call, record, unpack_words, wait_until, words

from gpr20_simulator.faults import PORT_TAKEN
from gpr20_simulator.low.portmapper import Portmapper, tcp_mapping
from gpr20_simulator.low.rpc import RpcProgram, pack_opaque
from gpr20_simulator.low.rpc_server import ListenError, RpcTcpServer

PROGRAM, VERSION, ECHO = 400000, 1, 1
LONGEST_RECORD = 1000
PMAP = 100000
SOCKET_LIMIT_S = 0.1


@pytest.fixture
def gone():
    return []


@pytest.fixture
def limited_sockets():
    """Every new socket gets a time limit, as rospy does it to its process."""
    socket.setdefaulttimeout(SOCKET_LIMIT_S)
    yield
    socket.setdefaulttimeout(None)


@pytest.fixture
def server(gone):
    echo = RpcProgram(PROGRAM, VERSION, {ECHO: lambda a, _c: pack_opaque(a.opaque(900))})
    one = RpcTcpServer("127.0.0.1", 0, echo, LONGEST_RECORD, 3, gone.append)
    one.start()
    yield one
    one.stop()


def echoed(client, data=b"still alive "):
    return client.result(PROGRAM, VERSION, ECHO, pack_opaque(data)) == pack_opaque(data)


def test_record_in_many_fragments_is_one_call(server):
    message = call(PROGRAM, VERSION, ECHO, pack_opaque(b"abcd"))
    with RawClient(server.port) as client:
        for place in range(0, len(message) - 4, 4):
            client.send(words(4) + message[place : place + 4])
        client.send(words(0))
        client.send(words(4 | LAST) + message[-4:])
        assert client.reply()[24:] == pack_opaque(b"abcd")


def test_record_in_single_bytes_is_one_call(server):
    with RawClient(server.port) as client:
        client.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in record(call(PROGRAM, VERSION, ECHO, pack_opaque(b"abcd"))):
            client.send(bytes([byte]))
        assert client.reply()[24:] == pack_opaque(b"abcd")


def test_calls_sent_together_are_answered_in_their_order(server):
    with RawClient(server.port) as client:
        client.send(b"".join(record(call(PROGRAM, VERSION, 0, xid=n)) for n in range(20)))
        assert [unpack_words(client.reply())[0] for _ in range(20)] == list(range(20))


@pytest.mark.parametrize(
    "data",
    [
        words((LONGEST_RECORD + 1) | LAST),
        words(0x7FFFFFFF | LAST),
        words(40)
        + call(PROGRAM, VERSION, 0)
        + words(LONGEST_RECORD | LAST)
        + bytes(LONGEST_RECORD),
        words(0) * 5000,
        record(b"no call at all"),
        record(words(7, 1, 0, 0, 0, 0)),
    ],
    ids=["too long", "2 GiB", "too long in two", "endless fragments", "garbage", "a reply"],
)
def test_stream_that_cannot_be_followed_is_closed_and_others_served(server, data):
    with RawClient(server.port) as good, RawClient(server.port) as bad:
        # The server may close before all of it is sent.
        with contextlib.suppress(OSError):
            bad.send(data)
        assert bad.is_closed()
        assert echoed(good)


def test_client_that_leaves_in_mid_record_is_forgotten(server, gone):
    with RawClient(server.port) as client:
        client.send(words(100 | LAST) + b"half")
    wait_until(lambda: len(gone) == 1, "end of the connection")
    with RawClient(server.port) as client:
        assert echoed(client)


def _is_served(server):
    with RawClient(server.port) as client:
        try:
            return echoed(client)
        except (EOFError, ConnectionResetError):
            return False


def test_connections_beyond_the_limit_are_turned_away(server):
    clients = [RawClient(server.port) for _ in range(3)]
    assert all(echoed(client) for client in clients)
    with RawClient(server.port) as refused:
        assert refused.is_closed()
    clients[0].sock.close()
    wait_until(lambda: _is_served(server), "a free place")
    for client in clients[1:]:
        client.sock.close()


def test_stopped_server_drops_its_clients_and_listens_no_more(server):
    with RawClient(server.port) as client:
        assert echoed(client)
        server.stop()
        assert client.is_closed()
    with pytest.raises(ConnectionRefusedError):
        RawClient(server.port)


def test_taken_port_is_a_clear_error(server):
    with raises_fault(PORT_TAKEN, server.port, error=ListenError):
        RpcTcpServer("127.0.0.1", server.port, RpcProgram(PROGRAM, VERSION, {}), LONGEST_RECORD, 1)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may listen on port 111")
def test_privileged_port_is_a_clear_error():
    with raises_fault(PORT_TAKEN, 111, error=ListenError):
        Portmapper("127.0.0.1", [], 111)


@pytest.fixture
def portmapper():
    mappings = [tcp_mapping(395183, 1, 4711), tcp_mapping(395184, 1, 4712)]
    one = Portmapper("127.0.0.1", mappings, 0)
    one.start()
    yield one
    one.stop()


GETPORTS = [
    ((395183, 1, 6, 0), 4711),
    ((395184, 1, 6, 0), 4712),
    ((395183, 1, 17, 0), 0),
    ((395183, 2, 6, 0), 0),
    ((1, 1, 6, 0), 0),
]


@each_case("wanted, port", GETPORTS)
def test_portmapper_tells_ports_on_tcp(portmapper, wanted, port):
    with RawClient(portmapper.port) as client:
        assert client.result(PMAP, 2, 3, words(*wanted)) == words(port)


@each_case("wanted, port", GETPORTS)
def test_portmapper_tells_ports_on_udp(portmapper, wanted, port):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.settimeout(5.0)
        sock.sendto(b"garbage", ("127.0.0.1", portmapper.port))
        sock.sendto(call(PMAP, 2, 3, words(*wanted)), ("127.0.0.1", portmapper.port))
        assert unpack_words(sock.recv(100)) == [7, 1, 0, 0, 0, 0, port]


def test_silent_clients_keep_their_connections_in_a_process_of_rospy(limited_sockets, server):
    with RawClient(server.port) as client:
        assert echoed(client)
        ended, _, _ = select.select([client.sock], [], [], 3 * SOCKET_LIMIT_S)
        assert not ended
        assert echoed(client)
    with RawClient(server.port) as client:
        assert echoed(client)


def test_portmapper_lists_what_it_knows(portmapper):
    with RawClient(portmapper.port) as client:
        assert unpack_words(client.result(PMAP, 2, 4)) == [
            *(1, 395183, 1, 6, 4711),
            *(1, 395184, 1, 6, 4712),
            0,
        ]


@each_case("procedure", [1, 2])
def test_nobody_can_change_the_portmapper(portmapper, procedure):
    with RawClient(portmapper.port) as client:
        assert client.result(PMAP, 2, procedure, words(395183, 1, 6, 1)) == words(0)
        assert client.result(PMAP, 2, 3, words(395183, 1, 6, 0)) == words(4711)


def test_stopped_portmapper_answers_no_more(portmapper):
    portmapper.stop()
    with pytest.raises(ConnectionRefusedError):
        RawClient(portmapper.port)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.settimeout(0.2)
        sock.connect(("127.0.0.1", portmapper.port))
        sock.send(call(PMAP, 2, 0))
        with pytest.raises(OSError):
            sock.recv(100)
