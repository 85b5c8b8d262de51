"""RPC over TCP and UDP: listening, one thread per connection."""

from __future__ import annotations

import socket
import threading
from typing import Callable, List, Sequence, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_simulator.low.rpc import RpcProgram, answer_call
from gpr20_simulator.low.rpc_connection import RpcConnection
from gpr20_simulator.low.xdr import XdrError

LONGEST_DATAGRAM = 8192
STOP_TIMEOUT_S = 5.0


class ListenError(Gpr20Error, OSError):
    """The server cannot listen where it was told to."""


class RpcTcpServer:
    """Serves programs on one TCP port.

    Args:
        host: Address to listen on.
        port: Port to listen on; 0: any free one.
        programs: What clients can call.
        longest_record: Longest call accepted [bytes].
        most_connections: Further clients are turned away at once.
        on_disconnect: Called with each connection after its last call.
    """

    def __init__(
        self,
        host: str,
        port: int,
        programs: Sequence[RpcProgram],
        longest_record: int,
        most_connections: int,
        on_disconnect: Callable[[RpcConnection], None] = lambda _connection: None,
    ) -> None:
        self._programs = programs
        self._longest_record = longest_record
        self._most_connections = most_connections
        self._on_disconnect = on_disconnect
        self._lock = threading.Lock()
        self._connections: List[RpcConnection] = []
        self._threads: List[threading.Thread] = []
        self._closing = False
        self._listener = bound_socket(socket.SOCK_STREAM, host, port)
        # Clients above the limit are accepted and turned away, not left waiting in a queue.
        self._listener.listen(socket.SOMAXCONN)
        self.port: int = self._listener.getsockname()[1]

    def start(self) -> None:
        """Begin to accept connections."""
        self._run(self._accept, f"rpc-accept-{self.port}")

    def drop_connections(self) -> None:
        """Close every connection; new ones are accepted."""
        with self._lock:
            connections = list(self._connections)
        for connection in connections:
            connection.drop()

    def close(self) -> None:
        """Stop listening and drop every connection, without waiting for the threads."""
        with self._lock:
            if self._closing:
                return
            self._closing = True
        # close() alone does not wake a thread that waits in accept().
        shut_down(self._listener)
        self.drop_connections()

    def stop(self) -> None:
        """Close, and wait for the threads to end."""
        self.close()
        with self._lock:
            threads = list(self._threads)
        for thread in threads:
            if thread is not threading.current_thread() and thread.is_alive():
                thread.join(STOP_TIMEOUT_S)
        self._listener.close()

    def _run(self, work: Callable[..., None], name: str, *arguments: object) -> None:
        thread = threading.Thread(target=work, args=arguments, name=name, daemon=True)
        with self._lock:
            self._threads = [one for one in self._threads if one.is_alive()]
            thread.start()
            self._threads.append(thread)

    def _accept(self) -> None:
        while True:
            try:
                sock, _address = self._listener.accept()
            except ConnectionAbortedError:
                continue
            except OSError:
                # The listener was closed; anything else would say so here for ever.
                return
            self._admit(RpcConnection(sock, self._longest_record))

    def _admit(self, connection: RpcConnection) -> None:
        with self._lock:
            admitted = not self._closing and len(self._connections) < self._most_connections
            if admitted:
                self._connections.append(connection)
        if admitted:
            self._run(self._serve, f"rpc-connection-{self.port}", connection)
        else:
            connection.close()

    def _serve(self, connection: RpcConnection) -> None:
        try:
            while True:
                record = connection.read_record()
                if record is None:
                    return
                reply = answer_call(self._programs, record, connection)
                if reply is not None and not connection.write_record(reply):
                    return
        except XdrError:
            # A stream that is out of step has no next record to look for.
            return
        finally:
            with self._lock:
                self._connections.remove(connection)
            self._on_disconnect(connection)
            connection.close()


class _DatagramCaller:
    def is_gone(self) -> bool:
        return False


class RpcUdpServer:
    """Serves programs on one UDP port; each datagram is one call."""

    def __init__(self, host: str, port: int, programs: Sequence[RpcProgram]) -> None:
        self._programs = programs
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
                reply = answer_call(self._programs, message, _DatagramCaller())
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


def bound_socket(kind: socket.SocketKind, host: str, port: int) -> socket.socket:
    """Return a socket bound to an address.

    Raises:
        ListenError: The port is taken or not allowed.
    """
    sock = socket.socket(socket.AF_INET, kind)
    if kind == socket.SOCK_STREAM:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        sock.bind((host, port))
    except OSError as error:
        sock.close()
        raise ListenError(
            f"cannot listen on {host} port {port}: {error.strerror}; "
            "free the port, choose another one, or (below 1024) run as root"
        ) from error
    return sock


def shut_down(sock: socket.socket) -> None:
    """Wake whoever waits on a listening or a datagram socket."""
    try:
        sock.shutdown(socket.SHUT_RDWR)
    except OSError:
        # A datagram socket without a peer reports an error, and wakes its reader all the same.
        return
