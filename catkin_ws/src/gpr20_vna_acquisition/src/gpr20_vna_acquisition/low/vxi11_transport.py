"""The VXI-11 link to an instrument: python-vxi11 0.9 with its faults contained.

The library connects without a time limit, raises exceptions of five families, cannot close
a dead link, and reuses a stream that is out of step. Here a link has time limits from the
first byte, raises only `VnaConnectionError`, and cannot be used again after a failure.
"""

from __future__ import annotations

import socket
import struct
import time
from dataclasses import dataclass
from typing import Any, Callable, Optional, TypeVar

from vxi11 import rpc, vxi11

from gpr20_common.errors import os_reason
from gpr20_common.message import Fault, Message
from gpr20_survey.faults import WRONG_VNA
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaNoAnswerError

Answer = TypeVar("Answer")

PORTMAPPER_PORT = 111
DEVICE_NAME = "inst0"
# VXI-11 rule B.6.3: a server accepts at least this much at once.
SMALLEST_RECEIVE_SIZE_BYTES = 1024
# The server's own time limit must end first, so that its error arrives before this one.
SERVER_MARGIN_S = 1.0
# A block of 4001 complex numbers in ASCII with 20 characters each is 168 kB.
LONGEST_ANSWER_BYTES = 1 << 20
CLOSE_TIMEOUT_S = 0.5
CHUNK_BYTES = 65536

# What python-vxi11 raises for peers that are lost, hang or send garbage.
LIBRARY_ERRORS = (
    vxi11.Vxi11Exception,
    rpc.RPCError,
    rpc.xdrlib.Error,
    struct.error,
    EOFError,
    OSError,
)
# Those of them with which an instrument that is a VXI-11 one is lost.
LOST_ERRORS = (vxi11.Vxi11Exception, EOFError, OSError)


@dataclass(frozen=True)
class LinkLimits:
    """Time limits of a link [s]."""

    connect_s: float = 3.0
    answer_s: float = 5.0


class DeadlineSocket:
    """The calls of a socket that python-vxi11's RPC client uses, bounded and complete.

    The time limit of a plain socket restarts with every byte, so a peer that sends single bytes can
    block its caller for ever. Here it covers everything until it is set again. And `recv` returns
    all the bytes that were requested: the RPC client takes a record header that arrives in two
    segments for the end of the stream. What has arrived is received at once, because the RPC client
    requests each record in two parts.
    """

    def __init__(self, address: str, port: int, timeout_s: float, limit_bytes: int) -> None:
        """Connect.

        Args:
            address: Four decimal numbers.
            port: TCP port.
            timeout_s: Time limit [s] for connecting and everything until it is set again.
            limit_bytes: Most that is received [bytes] before the time limit is set again.

        Raises:
            OSError: The connection could not be made in time.
        """
        self._limit_bytes = limit_bytes
        self.settimeout(timeout_s)
        self._socket = socket.create_connection((address, port), timeout=timeout_s)
        # Requests are small and each waits for its answer: collecting them gains nothing.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._received = bytearray()

    def settimeout(self, timeout_s: float) -> None:
        """Restart both limits: `timeout_s` [s] in total from now on, and the full size."""
        self._timeout_s = timeout_s
        self._deadline_s = time.monotonic() + timeout_s
        self._remaining_bytes = self._limit_bytes

    def sendall(self, data: bytes) -> None:
        """Send all data, or raise OSError."""
        self._in_time().sendall(data)

    def recv(self, count: int) -> bytes:
        """Return exactly `count` bytes, or fewer if the stream ends before them.

        Raises:
            OSError: The time limit is exceeded, or the peer sends more than allowed.
        """
        if count > self._remaining_bytes:
            raise OSError(
                f"the peer announces {count} bytes where at most {self._remaining_bytes} "
                "more are expected"
            )
        self._remaining_bytes -= count
        while len(self._received) < count:
            part = self._in_time().recv(CHUNK_BYTES)
            if not part:
                break
            self._received += part
        wanted = bytes(self._received[:count])
        del self._received[:count]
        return wanted

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _in_time(self) -> socket.socket:
        """Return the socket, limited to the time that is left."""
        remaining_s = self._deadline_s - time.monotonic()
        if remaining_s <= 0.0:
            raise socket.timeout(f"no complete answer within {self._timeout_s:g} s")
        self._socket.settimeout(remaining_s)
        return self._socket


class _Portmapper(rpc.TCPPortMapperClient):
    """Asks the instrument for the TCP port of its VXI-11 core channel."""

    def __init__(self, address: str, port: int, timeout_s: float) -> None:
        self._asked_port, self._timeout_s = port, timeout_s
        super().__init__(address)

    def connect(self) -> None:
        self.sock = DeadlineSocket(
            self.host, self._asked_port, self._timeout_s, LONGEST_ANSWER_BYTES
        )


class _CoreChannel(vxi11.CoreClient):
    """The core channel at a known port, connected with a time limit."""

    def __init__(self, address: str, port: int, timeout_s: float) -> None:
        self._timeout_s = timeout_s
        super().__init__(address, port)

    def connect(self) -> None:
        # Twice the longest answer leaves room for the RPC headers of its pieces.
        self.sock = DeadlineSocket(self.host, self.port, self._timeout_s, 2 * LONGEST_ANSWER_BYTES)


class _Instrument(vxi11.Instrument):
    """The library's client without its destructor, which would use a dead link."""

    def __del__(self) -> None:
        pass


class Vxi11Transport:
    """Implements `Transport`: one VXI-11 link, made by `connect`; after any failure it is dead."""

    def __init__(self, address: str, instrument: Any, limits: LinkLimits) -> None:
        self._address = address
        self._instrument: Optional[Any] = instrument
        self._limits = limits

    def write(self, command: str) -> None:
        """Send a command that has no answer."""
        self._call(f"sending '{command}'", lambda link: link.write_raw(command.encode()))

    def ask_raw(self, query: str, limit_s: Optional[float] = None) -> bytes:
        """Send a query and return its answer, byte for byte, within a time limit of its own [s]."""
        answer: bytes = self._call(
            f"asking '{query}'", lambda link: link.ask_raw(query.encode()), limit_s
        )
        return answer

    def clear(self) -> None:
        """Empty the instrument's input and output buffers, if it supports that."""
        self._call("clearing the instrument", lambda link: _if_supported(link.clear))

    def lock(self) -> None:
        """Keep all other links from using the instrument, if it supports that."""
        self._call("locking the instrument", lambda link: _if_supported(link.lock))

    def local(self) -> None:
        """Return the control to the front panel, if the instrument supports that."""
        self._call("returning to the front panel", lambda link: _if_supported(link.local))

    def close(self) -> None:
        """End the link. Never fails; closing a dead or closed link does nothing."""
        instrument, self._instrument = self._instrument, None
        if instrument is not None:
            _end(instrument)

    def _call(
        self, what: str, function: Callable[[Any], Answer], limit_s: Optional[float] = None
    ) -> Answer:
        if self._instrument is None:
            raise VnaConnectionError(
                Message(
                    "the connection to the VNA at {address} is closed",
                    address=self._address,
                    details=what,
                )
            )
        answer_s = self._limits.answer_s if limit_s is None else limit_s
        try:
            self._instrument.timeout = answer_s
            self._instrument.client.sock.settimeout(answer_s + SERVER_MARGIN_S)
            return function(self._instrument)
        except LIBRARY_ERRORS as error:
            # A late answer would be taken for that of the next query, so the link ends.
            self.close()
            kind = VnaNoAnswerError if _is_timeout(error) else VnaConnectionError
            raise kind(
                Message(
                    "communication with the VNA at {address} failed: {reason}; check the VNA and "
                    "its network cable",
                    address=self._address,
                    reason=_reason(error),
                    details=what,
                ),
                fault=errors.LOCKED if _is_locked(error) else None,
            ) from error


def connect(
    address: str,
    limits: LinkLimits,
    core_port: Optional[int] = None,
    portmapper_port: int = PORTMAPPER_PORT,
) -> Vxi11Transport:
    """Open a link to the instrument at an address.

    Args:
        address: Four decimal numbers.
        limits: Time limits of the link.
        core_port: TCP port of the core channel; without it the portmapper is asked.
        portmapper_port: TCP port of the portmapper.

    Raises:
        VnaConnectionError: No link was made within the time limit.
    """
    instrument = _Instrument(address, DEVICE_NAME)
    instrument.timeout = limits.connect_s
    try:
        port = core_port or _mapped_port(address, portmapper_port, limits.connect_s)
        # With a client given, the library does not make its own, which would block.
        instrument.client = _CoreChannel(address, port, limits.connect_s)
        instrument.open()
        if instrument.max_recv_size < SMALLEST_RECEIVE_SIZE_BYTES:
            raise rpc.RPCError(
                f"{instrument.max_recv_size} bytes at once; VXI-11 requires at least 1024"
            )
    except LIBRARY_ERRORS as error:
        _end(instrument)
        raise VnaConnectionError(
            Message(
                "no connection to the VNA at {address} ({reason}); check its address, its network "
                "cable and that it is switched on",
                address=address,
                reason=_reason(error),
            ),
            fault=_link_fault(error),
        ) from error
    return Vxi11Transport(address, instrument, limits)


def _mapped_port(address: str, portmapper_port: int, timeout_s: float) -> int:
    portmapper = _Portmapper(address, portmapper_port, timeout_s)
    try:
        port: int = portmapper.get_port(
            (vxi11.DEVICE_CORE_PROG, vxi11.DEVICE_CORE_VERS, rpc.IPPROTO_TCP, 0)
        )
    finally:
        portmapper.close()
    if not 0 < port < 65536:
        raise rpc.RPCError("the portmapper knows no VXI-11 core channel")
    return port


def _if_supported(call: Callable[[], Any]) -> None:
    """Make a call that an instrument need not support."""
    try:
        call()
    except vxi11.Vxi11Exception as error:
        if error.err != vxi11.ERR_OPERATION_NOT_SUPPORTED:
            raise
    except rpc.RPCUnpackError:
        # The server does not have the procedure. Its answer was read whole, so the link is in
        # step; a server with another fault fails at the next exchange.
        return


def _end(instrument: Any) -> None:
    link, client = instrument.link, instrument.client
    instrument.link = instrument.client = None
    if client is None:
        return
    try:
        if link is not None:
            # The instrument has few links; a closed socket alone may not free this one.
            client.sock.settimeout(CLOSE_TIMEOUT_S)
            client.destroy_link(link)
    except LIBRARY_ERRORS:
        # The link failed already or is no longer needed: there is nothing to report.
        pass
    finally:
        client.close()


def _is_timeout(error: BaseException) -> bool:
    own_timeout = isinstance(error, vxi11.Vxi11Exception) and error.err == vxi11.ERR_IO_TIMEOUT
    return own_timeout or isinstance(error, socket.timeout)


def _is_locked(error: BaseException) -> bool:
    code = error.err if isinstance(error, vxi11.Vxi11Exception) else None
    return code == vxi11.ERR_DEVICE_LOCKED_BY_ANOTHER_LINK


def _link_fault(error: BaseException) -> Optional[Fault]:
    if _is_locked(error):
        return errors.LOCKED
    return None if isinstance(error, LOST_ERRORS) else WRONG_VNA


def _reason(error: BaseException) -> Message:
    if isinstance(error, EOFError):
        return Message("the connection was closed by the other side")
    if _is_locked(error):
        return Message("another program has locked it", details=error)
    if _is_timeout(error):
        return Message("no answer in time", details=error)
    if isinstance(error, OSError) and error.errno is not None:
        return os_reason(error)
    if isinstance(error, vxi11.Vxi11Exception):
        return Message("the VNA reports an error", details=error)
    return Message(
        "it does not answer as a VXI-11 instrument", details=f"{type(error).__name__}: {error}"
    )
