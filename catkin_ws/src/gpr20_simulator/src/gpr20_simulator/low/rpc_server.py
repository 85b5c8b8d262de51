"""RPC over TCP: listening, one thread per connection, records in fragments."""

from __future__ import annotations

import socket
import struct
import threading
from typing import Callable, List, Optional

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.message import Message
from gpr20_simulator.low.rpc import RpcProgram, XdrError, answer_call

LAST_FRAGMENT = 0x80000000
MOST_FRAGMENTS = 4096
CHUNK_BYTES = 65536
# A client that does not take its replies for this long loses its connection.
SEND_TIMEOUT_S = 30.0
STOP_TIMEOUT_S = 5.0


class ListenError(Gpr20Error, OSError):
    """The server cannot listen on the given address."""

    fault = OTHER_LAUNCH


class RpcConnection:
    """One accepted TCP connection: records in, records out."""

    def __init__(self, sock: socket.socket, longest_record: int) -> None:
        self._socket = sock
        self._longest_record = longest_record
        self._received = bytearray()
        _wait_without_limit(sock)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # Limits sending alone: a client may be silent for as long as it likes.
        seconds = struct.pack("ll", int(SEND_TIMEOUT_S), 0)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, seconds)

    def is_gone(self) -> bool:
        """Return whether the client has closed the connection."""
        if self._received:
            return False
        try:
            return self._socket.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True

    def drop(self) -> None:
        """Close the connection from any thread; a reader of it finds its end."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # The client was quicker; closed is what it should be.
            return

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()

    def read_record(self) -> Optional[bytes]:
        """Return the next record, put together from its fragments; None at the end.

        Raises:
            XdrError: The record is longer, or in more fragments, than is allowed.
        """
        record = bytearray()
        for _ in range(MOST_FRAGMENTS):
            header = self._read_exactly(4)
            if header is None:
                return None
            word = int.from_bytes(header, "big")
            length = word & ~LAST_FRAGMENT
            if len(record) + length > self._longest_record:
                raise XdrError(f"a record of more than {self._longest_record} bytes")
            fragment = self._read_exactly(length)
            if fragment is None:
                return None
            record += fragment
            if word & LAST_FRAGMENT:
                return bytes(record)
        raise XdrError(f"a record of more than {MOST_FRAGMENTS} fragments")

    def write_record(self, record: bytes) -> bool:
        """Send a record as one fragment; return whether the client took it."""
        try:
            self._socket.sendall((len(record) | LAST_FRAGMENT).to_bytes(4, "big") + record)
        except OSError:
            return False
        return True

    def _read_exactly(self, length: int) -> Optional[bytes]:
        # What has arrived is received at once: mostly a whole record.
        received = self._received
        while len(received) < length:
            try:
                piece = self._socket.recv(CHUNK_BYTES)
            except OSError:
                # A connection that breaks has ended like one that is closed.
                return None
            if not piece:
                return None
            received += piece
        data = bytes(received[:length])
        del received[:length]
        return data


class RpcTcpServer:
    """Serves a program on one TCP port.

    Args:
        host: Address to listen on.
        port: Port to listen on; 0: any free one.
        program: What clients can call.
        longest_record: Longest call accepted [bytes].
        most_connections: Further clients are turned away at once.
        on_disconnect: Called with each connection after its last call.
        is_reachable: While it returns False new connections are closed at once.
    """

    def __init__(
        self,
        host: str,
        port: int,
        program: RpcProgram,
        longest_record: int,
        most_connections: int,
        on_disconnect: Callable[[RpcConnection], None] = lambda _connection: None,
        is_reachable: Callable[[], bool] = lambda: True,
    ) -> None:
        self._program = program
        self._longest_record = longest_record
        self._most_connections = most_connections
        self._on_disconnect = on_disconnect
        self._is_reachable = is_reachable
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
            admitted = admitted and self._is_reachable()
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
                reply = answer_call(self._program, record, connection)
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


def bound_socket(kind: socket.SocketKind, host: str, port: int) -> socket.socket:
    """Return a socket bound to an address.

    Raises:
        ListenError: The port is taken or not allowed.
    """
    sock = socket.socket(socket.AF_INET, kind)
    _wait_without_limit(sock)
    if kind == socket.SOCK_STREAM:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        sock.bind((host, port))
    except OSError as error:
        sock.close()
        raise ListenError(
            Message(
                "cannot listen on {host} port {port}: {reason}; free the port, choose another one, "
                "or run as root for a port below 1024",
                host=host,
                port=port,
                reason=os_reason(error),
            )
        ) from error
    return sock


def _wait_without_limit(sock: socket.socket) -> None:
    # rospy gives every new socket of its process a limit of 60 s: a silent client would lose its
    # connection, and a look at what has arrived would wait so long.
    sock.settimeout(None)


def shut_down(sock: socket.socket) -> None:
    """Wake the thread that waits on a listening or a datagram socket."""
    try:
        sock.shutdown(socket.SHUT_RDWR)
    except OSError:
        # A datagram socket without a peer reports an error, and wakes its reader all the same.
        return
