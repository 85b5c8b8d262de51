"""Remote procedure calls, and the server and port mapper that take them from the network."""

from __future__ import annotations

import contextlib
import select
import socket

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from vxi11_wire import LAST, RawClient, call, record, unpack_words, words

from gpr20_simulator.low.portmapper import Portmapper, tcp_mapping
from gpr20_simulator.low.rpc import (
    RpcProgram,
    XdrError,
    answer_call,
    pack_opaque,
    pack_uint,
)
from gpr20_simulator.low.rpc_server import RpcTcpServer

PROGRAM, VERSION, ADD, SILENT, ECHO = 400000, 3, 1, 2, 3
LONGEST_RECORD, MOST_CLIENTS = 1000, 16
PMAP = 100000
SOCKET_LIMIT_S = 0.1


class Nobody:
    def is_gone(self):
        return False


def add(arguments, _caller):
    return pack_uint((arguments.uint() + arguments.uint()) & 0xFFFFFFFF)


OFFERED = RpcProgram(
    PROGRAM,
    VERSION,
    {ADD: add, SILENT: lambda _a, _c: None, ECHO: lambda a, _c: pack_opaque(a.opaque(900))},
)


def answered(message):
    return answer_call(OFFERED, message, Nobody())


@each_case(
    "message, reply",
    [
        (call(PROGRAM, VERSION, ADD, words(40, 2)), [7, 1, 0, 0, 0, 0, 42]),
        # What is wrong: program, version, procedure, arguments, version of RPC.
        (call(PROGRAM + 1, VERSION, ADD), [7, 1, 0, 0, 0, 1]),
        (call(PROGRAM, VERSION + 1, ADD), [7, 1, 0, 0, 0, 2, VERSION, VERSION]),
        (call(PROGRAM, VERSION, 99), [7, 1, 0, 0, 0, 3]),
        (call(PROGRAM, VERSION, ADD, words(1)), [7, 1, 0, 0, 0, 4]),
        (words(7, 0, 3, PROGRAM, VERSION, ADD, 0, 0, 0, 0), [7, 1, 1, 0, 2, 2]),
    ],
)
def test_calls_are_answered_or_told_what_is_wrong(message, reply):
    assert unpack_words(answered(message)) == reply


@given(st.one_of(st.binary(max_size=200), st.binary(max_size=60).map(lambda d: words(7, 0, 2) + d)))
def test_no_bytes_do_anything_but_get_an_answer_or_an_xdr_error(message):
    try:
        reply = answered(message)
    except XdrError:
        return
    assert reply is None or reply[:8] == message[:4] + words(1)


# The server.


@pytest.fixture
def server():
    one = RpcTcpServer("127.0.0.1", 0, OFFERED, LONGEST_RECORD, MOST_CLIENTS)
    one.start()
    yield one
    one.stop()


def echoed(client, data=b"still alive "):
    return client.result(PROGRAM, VERSION, ECHO, pack_opaque(data)) == pack_opaque(data)


def test_record_in_pieces_is_one_call(server):
    message = call(PROGRAM, VERSION, ECHO, pack_opaque(b"abcd"))
    with RawClient(server.port) as client:
        client.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in record(message):
            client.send(bytes([byte]))
        assert client.reply()[24:] == pack_opaque(b"abcd")
        for place in range(0, len(message) - 4, 4):
            client.send(words(4) + message[place : place + 4])
        client.send(words(0) + words(4 | LAST) + message[-4:])
        assert client.reply()[24:] == pack_opaque(b"abcd")


@each_case(
    "data",
    [
        words((LONGEST_RECORD + 1) | LAST),
        # Too long in two.
        words(40) + call(PROGRAM, VERSION, 0) + words(LONGEST_RECORD | LAST) + bytes(1000),
        words(0) * 5000,
        record(words(7, 1, 0, 0, 0, 0)),
    ],
)
def test_stream_that_cannot_be_followed_is_closed_and_others_served(server, data):
    with RawClient(server.port) as good, RawClient(server.port) as bad:
        # The server may close before all of it is sent.
        with contextlib.suppress(OSError):
            bad.send(data)
        assert bad.is_closed()
        assert echoed(good)


def test_connections_beyond_the_limit_are_turned_away(server):
    clients = [RawClient(server.port) for _ in range(MOST_CLIENTS)]
    assert all(echoed(client) for client in clients)
    with RawClient(server.port) as refused:
        assert refused.is_closed()
    for client in clients:
        client.sock.close()


def test_silent_clients_keep_their_connections_in_a_process_of_rospy():
    # Every new socket gets a time limit, as rospy does it to its process.
    socket.setdefaulttimeout(SOCKET_LIMIT_S)
    try:
        server = RpcTcpServer("127.0.0.1", 0, OFFERED, LONGEST_RECORD, MOST_CLIENTS)
        server.start()
        with RawClient(server.port) as client:
            assert echoed(client)
            ended, _, _ = select.select([client.sock], [], [], 3 * SOCKET_LIMIT_S)
            assert not ended and echoed(client)
        server.stop()
    finally:
        socket.setdefaulttimeout(None)


# The port mapper.


@pytest.fixture
def portmapper():
    mappings = [tcp_mapping(395183, 1, 4711), tcp_mapping(395184, 1, 4712)]
    one = Portmapper("127.0.0.1", mappings, 0)
    one.start()
    yield one
    one.stop()


@each_case(
    "wanted, port",
    [
        ((395183, 1, 6, 0), 4711),
        ((395183, 1, 17, 0), 0),
    ],
)
def test_portmapper_tells_ports_on_tcp_and_udp(portmapper, wanted, port):
    with RawClient(portmapper.port) as client:
        # Nobody can change them.
        for procedure in (1, 2):
            assert client.result(PMAP, 2, procedure, words(395183, 1, 6, 1)) == words(0)
        assert client.result(PMAP, 2, 3, words(*wanted)) == words(port)
        listed = unpack_words(client.result(PMAP, 2, 4))
        assert listed == [1, 395183, 1, 6, 4711, 1, 395184, 1, 6, 4712, 0]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.settimeout(30.0)
        sock.sendto(b"garbage", ("127.0.0.1", portmapper.port))
        sock.sendto(call(PMAP, 2, 3, words(*wanted)), ("127.0.0.1", portmapper.port))
        assert unpack_words(sock.recv(100)) == [7, 1, 0, 0, 0, 0, port]
