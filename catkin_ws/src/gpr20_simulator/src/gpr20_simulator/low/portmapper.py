"""The portmapper: answers on which port a program listens."""

from __future__ import annotations

import socket
import threading
from dataclasses import dataclass
from typing import Sequence, Tuple

from gpr20_simulator.low.rpc import (
    Caller,
    RpcProgram,
    XdrError,
    XdrReader,
    answer_call,
    pack_uint,
)
from gpr20_simulator.low.rpc_server import (
    STOP_TIMEOUT_S,
    ListenError,
    RpcTcpServer,
    bound_socket,
    shut_down,
)

PORT = 111
PROGRAM = 100000
VERSION = 2
SET, UNSET, GETPORT, DUMP = 1, 2, 3, 4
LONGEST_RECORD = 8192
LONGEST_DATAGRAM = 8192
MOST_CONNECTIONS = 16
FREE_PORT_TRIALS = 20


@dataclass(frozen=True)
class Mapping:
    """A program and where it listens; protocol is IPPROTO_TCP or IPPROTO_UDP."""

    program: int
    version: int
    protocol: int
    port: int


class _DatagramCaller:
    def is_gone(self) -> bool:
        return False


class RpcUdpServer:
    """Serves a program on one UDP port; each datagram is one call."""

    def __init__(self, host: str, port: int, program: RpcProgram) -> None:
        self._program = program
        self._closing = False
        self._socket = bound_socket(socket.SOCK_DGRAM, host, port)
        self.port: int = self._socket.getsockname()[1]
        self._thread = threading.Thread(
            target=self._serve, name=f"rpc-udp-{self.port}", daemon=True
        )

    def start(self) -> None:
        """Begin to answer."""
        self._thread.start()

    def close(self) -> None:
        """Stop answering, without waiting for the thread."""
        self._closing = True
        shut_down(self._socket)

    def stop(self) -> None:
        """Stop answering, and wait for the thread to end."""
        self.close()
        if self._thread.is_alive():
            self._thread.join(STOP_TIMEOUT_S)
        self._socket.close()

    def _serve(self) -> None:
        while not self._closing:
            try:
                message, address = self._socket.recvfrom(LONGEST_DATAGRAM)
            except OSError:
                # The news that an earlier client did not get its reply; the next call is another's.
                continue
            try:
                reply = answer_call(self._program, message, _DatagramCaller())
            except XdrError:
                # Not a call, so nobody waits for a reply.
                continue
            if reply is not None:
                self._send(reply, address)

    def _send(self, reply: bytes, address: Tuple[str, int]) -> None:
        try:
            self._socket.sendto(reply, address)
        except OSError:
            # As lost as any datagram can be; the client asks again.
            return


class Portmapper:
    """Answers on TCP and UDP; its list is fixed, nobody can register or remove.

    Args:
        host: Address to listen on.
        mappings: What is known.
        port: 111 is where clients look and needs privileges; 0: any free one.

    Raises:
        ListenError: The port is taken (rpcbind runs?) or not allowed.
    """

    def __init__(self, host: str, mappings: Sequence[Mapping], port: int = PORT) -> None:
        self._mappings = tuple(mappings)
        program = RpcProgram(
            PROGRAM,
            VERSION,
            {SET: self._refuse, UNSET: self._refuse, GETPORT: self._get_port, DUMP: self._dump},
        )
        self._tcp, self._udp = _servers(host, port, program)
        self.port = self._tcp.port

    def start(self) -> None:
        """Begin to answer."""
        self._tcp.start()
        self._udp.start()

    def close(self) -> None:
        """Stop answering, without waiting for the threads."""
        self._tcp.close()
        self._udp.close()

    def stop(self) -> None:
        """Stop answering, and wait for the threads to end."""
        self._tcp.stop()
        self._udp.stop()

    def _refuse(self, _arguments: XdrReader, _caller: Caller) -> bytes:
        return pack_uint(0)

    def _get_port(self, arguments: XdrReader, _caller: Caller) -> bytes:
        wanted = (arguments.uint(), arguments.uint(), arguments.uint())
        for one in self._mappings:
            if (one.program, one.version, one.protocol) == wanted:
                return pack_uint(one.port)
        return pack_uint(0)

    def _dump(self, _arguments: XdrReader, _caller: Caller) -> bytes:
        items = [(1, one.program, one.version, one.protocol, one.port) for one in self._mappings]
        return b"".join(pack_uint(word) for item in items for word in item) + pack_uint(0)


def _servers(host: str, port: int, program: RpcProgram) -> Tuple[RpcTcpServer, RpcUdpServer]:
    for trial in range(FREE_PORT_TRIALS):
        tcp = RpcTcpServer(host, port, program, LONGEST_RECORD, MOST_CONNECTIONS)
        try:
            return tcp, RpcUdpServer(host, tcp.port, program)
        except ListenError:
            # A free TCP port can be taken on UDP; only then is another trial of use.
            tcp.stop()
            if port != 0 or trial == FREE_PORT_TRIALS - 1:
                raise
    raise AssertionError("unreachable")


def tcp_mapping(program: int, version: int, port: int) -> Mapping:
    """Return the mapping of a program on TCP."""
    return Mapping(program, version, socket.IPPROTO_TCP, port)
