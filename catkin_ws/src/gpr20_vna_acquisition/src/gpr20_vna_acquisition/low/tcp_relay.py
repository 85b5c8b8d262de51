"""A TCP port of this computer that stands for one of another, and loses bytes when asked to."""

from __future__ import annotations

import contextlib
import socket
import threading
from typing import List, Tuple

# Not the loopback address that servers use, so that a relay can have their port.
ADDRESS = "127.0.0.2"
CONNECT_LIMIT_S = 5.0
CHUNK_BYTES = 65536


class TcpRelay:
    """Passes on the bytes of every connection to a port, in both directions.

    Attributes:
        silent: Whether the bytes of the other side are thrown away.
        replaced: What is replaced in those that come in one piece, and by what.
    """

    def __init__(self, host: str, port: int) -> None:
        """Begin to listen, at `ADDRESS` with the same port.

        Raises:
            OSError: The port is taken.
        """
        self.silent = False
        self.replaced: Tuple[bytes, bytes] = (b"", b"")
        self._target = (host, port)
        self._lock = threading.Lock()
        self._sockets: List[socket.socket] = []
        self._listener = socket.create_server((ADDRESS, port))
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self) -> TcpRelay:
        return self

    def __exit__(self, *_error: object) -> None:
        # A thread that waits for connections returns only then.
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.drop()

    def drop(self) -> None:
        """End every connection."""
        with self._lock:
            ended, self._sockets = self._sockets, []
        for one in ended:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def _accept(self) -> None:
        while True:
            try:
                near, _address = self._listener.accept()
            except OSError:
                return  # the relay has ended
            try:
                far = socket.create_connection(self._target, CONNECT_LIMIT_S)
            except OSError:
                near.close()
                continue
            far.settimeout(None)
            with self._lock:
                self._sockets += [near, far]
            for source, sink in ((near, far), (far, near)):
                threading.Thread(target=self._pass, args=(source, sink), daemon=True).start()

    def _pass(self, source: socket.socket, sink: socket.socket) -> None:
        answers = sink.getsockname()[0] == ADDRESS
        with contextlib.suppress(OSError):
            while True:
                data = source.recv(CHUNK_BYTES)
                if not data:
                    break
                if answers:
                    data = b"" if self.silent else data.replace(*self.replaced)
                sink.sendall(data)
        for one in (source, sink):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
