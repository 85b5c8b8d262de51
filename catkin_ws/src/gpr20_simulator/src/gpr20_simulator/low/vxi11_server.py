"""A device on a VXI-11 socket of this machine, and a portmapper that tells its port.

As much of VXI-11 (revision 1.0) over ONC RPC (RFC 5531, 4506) as python-vxi11 and PyVISA use; every
other procedure is answered as one that the program does not have.
"""

from __future__ import annotations

import itertools
import select
import socket
import socketserver
import struct
import threading
from collections import deque
from typing import Any, Callable, Deque, Dict, List, Mapping, Optional, Set

from vxi11 import rpc, vxi11

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.message import Message
from gpr20_simulator.low.message_device import ClearSupport, MessageDevice, NetworkFault

HOST, PORTMAPPER_PORT = "127.0.0.1", rpc.PMAP_PORT
# How soon a server notices that it is to stop.
STOP_POLL_S = 0.1
DEVICE_NAME = b"inst0"
RECEIVE_SIZE = 65536
LONGEST_BYTES = 1 << 20  # of a call, of a message, and of what one read returns
MOST_LINKS = 16
MOST_UNREAD_ANSWERS = 64
LAST_FRAGMENT = 0x80000000
WORD = struct.Struct(">I")
# The number of a call and its procedure; between them its kind, RPC's version, the program and its.
CALL_HEAD = struct.Struct(">I16xI")
# What follows the number of a reply: it is one, accepted, with an empty verifier.
ACCEPTED = struct.pack(">4I", rpc.REPLY, rpc.MSG_ACCEPTED, rpc.AUTH_NULL, 0)
NO_ERROR = WORD.pack(vxi11.ERR_NO_ERROR)
# How many zeros follow an error code.
AFTER_ERROR = {vxi11.CREATE_LINK: 12, vxi11.DEVICE_WRITE: 4, vxi11.DEVICE_READ: 8}


class ListenError(Gpr20Error, OSError):
    """The server cannot listen on the given port."""

    fault = OTHER_LAUNCH


class _NoReply(Exception):
    """The client is to wait in vain."""


class _Unavailable(Exception):
    """A procedure acts as if the program did not have it."""


class _Refused(Exception):
    """A call cannot be carried out; its argument is the error code that the client gets."""


class _Connection(socketserver.StreamRequestHandler):
    """One client and its link: what it has written and not ended, and what it has not read.

    An unread answer stays in front of the next one: a client that missed an answer and continues
    reads the wrong one, as it would on an instrument. A late one comes with the next message.
    """

    disable_nagle_algorithm = True
    server: _RpcServer

    def setup(self) -> None:
        super().setup()
        self.link = 0
        self.incoming = bytearray()
        self.answers: Deque[bytes] = deque(maxlen=MOST_UNREAD_ANSWERS)
        self.late: List[bytes] = []

    def handle(self) -> None:
        try:
            while True:
                reply = self.server.reply(self, self._record())
                if reply is not None:
                    self.wfile.write(WORD.pack(len(reply) | LAST_FRAGMENT) + reply)
        except (EOFError, OSError, struct.error):
            return  # the client has left, or sends what is no call

    def finish(self) -> None:
        super().finish()
        self.server.left(self)

    def _record(self) -> bytes:
        record, is_last = b"", False
        while not is_last:
            (word,) = WORD.unpack(self.rfile.read(WORD.size))
            is_last, length = bool(word & LAST_FRAGMENT), word & ~LAST_FRAGMENT
            if len(record) + length > LONGEST_BYTES:
                raise EOFError
            record += self.rfile.read(length)
        return record


# Takes the arguments, packed, and returns the result, packed.
Procedure = Callable[[_Connection, bytes], bytes]


class _RpcServer(socketserver.ThreadingTCPServer):
    """The procedures of one program on one TCP port, with one thread for each connection."""

    allow_reuse_address = True
    daemon_threads = True
    request_queue_size = socket.SOMAXCONN

    def __init__(
        self,
        port: int,
        procedures: Mapping[int, Procedure],
        is_reachable: Callable[[], bool] = lambda: True,
        left: Callable[[_Connection], None] = lambda _connection: None,
    ) -> None:
        self.left = left
        self._procedures, self._is_reachable = procedures, is_reachable
        self._sockets: List[socket.socket] = []
        self._thread = threading.Thread(
            target=self.serve_forever, args=(STOP_POLL_S,), name="vxi11-server", daemon=True
        )
        try:
            super().__init__((HOST, port), _Connection)
        except OSError as error:
            raise ListenError(
                Message(
                    "cannot listen on {host} port {port}: {reason}; free the port, choose another "
                    "one, or run as root for a port below 1024",
                    host=HOST,
                    port=port,
                    reason=os_reason(error),
                )
            ) from error
        self.port: int = self.server_address[1]

    def process_request(self, request: Any, client_address: Any) -> None:
        # rospy gives every new socket of its process a limit of 60 s; a client may be silent.
        request.settimeout(None)
        self._sockets.append(request)
        if self._is_reachable():
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        self._sockets.remove(request)
        super().shutdown_request(request)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        if self._thread.is_alive():
            self.shutdown()
        self.server_close()
        self.drop_connections()

    def drop_connections(self) -> None:
        for one in list(self._sockets):
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                continue  # the client was quicker; closed is what it should be

    def reply(self, connection: _Connection, record: bytes) -> Optional[bytes]:
        """Return the reply to a call; None: there is none."""
        number, procedure = CALL_HEAD.unpack_from(record)
        place = CALL_HEAD.size
        for _credential_and_verifier in range(2):
            (length,) = WORD.unpack_from(record, place + WORD.size)
            place += 2 * WORD.size + length + -length % 4
        status, result = rpc.SUCCESS, b""
        try:
            result = self._procedures[procedure](connection, record[place:])
        except _Refused as refusal:
            result = WORD.pack(*refusal.args) + bytes(AFTER_ERROR.get(procedure, 0))
        except (KeyError, _Unavailable):
            status = rpc.PROC_UNAVAIL
        except _NoReply:
            return None
        return WORD.pack(number) + ACCEPTED + WORD.pack(status) + result


class Vxi11Server:
    """Serves one device as `inst0`.

    Args:
        device: What is served.
        port: Port of the core channel; 0: any free one.
        portmapper_port: Port of an own portmapper (111 is where clients look; 0: any free one);
            None: no portmapper, clients must know the port.

    Raises:
        ListenError: A port is taken or not allowed.
    """

    def __init__(
        self, device: MessageDevice, port: int = 0, portmapper_port: Optional[int] = None
    ) -> None:
        self._device = device
        self._changing = threading.RLock()
        self._linked: Set[_Connection] = set()
        self._numbers = itertools.count(1)
        self._lock_holder: Optional[_Connection] = None
        self._core = _RpcServer(port, self._procedures(), device.is_reachable, self._remove)
        self._servers = [self._core]
        if portmapper_port is not None:
            asked = {rpc.PMAPPROC_GETPORT: self._get_port}
            self._servers.append(_RpcServer(portmapper_port, asked))
        self.port, self.portmapper_port = self._core.port, self._servers[-1].port

    @property
    def link_count(self) -> int:
        """Number of links at the moment."""
        return len(self._linked)

    def start(self) -> None:
        """Begin to serve."""
        for server in self._servers:
            server.start()

    def stop(self) -> None:
        """Stop listening and drop every client."""
        for server in self._servers:
            server.stop()

    def drop_connections(self) -> None:
        """Close every connection."""
        self._core.drop_connections()

    def _procedures(self) -> Dict[int, Procedure]:
        return {
            vxi11.CREATE_LINK: self._create_link,
            vxi11.DEVICE_WRITE: self._write,
            vxi11.DEVICE_READ: self._read,
            vxi11.DEVICE_CLEAR: self._generic(self._clear),
            vxi11.DEVICE_REMOTE: self._generic(lambda _link: self._device.set_remote(True)),
            vxi11.DEVICE_LOCAL: self._generic(lambda _link: self._device.set_remote(False)),
            vxi11.DEVICE_LOCK: self._generic(self._take_lock),
            vxi11.DEVICE_UNLOCK: self._generic(self._unlock),
            vxi11.DESTROY_LINK: self._generic(self._remove),
        }

    def _create_link(self, connection: _Connection, arguments: bytes) -> bytes:
        (length,) = struct.unpack_from(">12xI", arguments)
        if arguments[16 : 16 + length].lower() != DEVICE_NAME:
            raise _Refused(vxi11.ERR_DEVICE_NOT_ACCESSIBLE)
        self._suffer(self._device.opened())
        with self._changing:
            if connection in self._linked or len(self._linked) >= MOST_LINKS:
                raise _Refused(vxi11.ERR_OUT_OF_RESOURCES)
            self._linked.add(connection)
            connection.link = next(self._numbers)
        no_abort_channel = 0
        return NO_ERROR + struct.pack(">3I", connection.link, no_abort_channel, RECEIVE_SIZE)

    def _write(self, link: _Connection, arguments: bytes) -> bytes:
        number, _io_ms, _lock_ms, flags, length = struct.unpack_from(">5I", arguments)
        self._check_access(link, number)
        if len(link.incoming) + length > LONGEST_BYTES:
            raise _Refused(vxi11.ERR_PARAMETER_ERROR)
        link.incoming += arguments[20 : 20 + length]
        if flags & vxi11.OP_FLAG_END:
            outcome = self._device.execute(bytes(link.incoming))
            link.incoming.clear()
            link.answers.extend(link.late)
            is_late = outcome.fault is NetworkFault.ANSWER_LATE
            link.late = [outcome.answer] if is_late else []
            if outcome.answer and not is_late:
                link.answers.append(outcome.answer)
            self._suffer(outcome.fault)
        return NO_ERROR + WORD.pack(length)

    def _read(self, link: _Connection, arguments: bytes) -> bytes:
        number, size, io_ms = struct.unpack_from(">3I", arguments)
        self._check_access(link, number)
        if not link.answers:
            # None can come meanwhile: what the client writes is carried out at once.
            select.select([link.request], [], [], io_ms / 1000.0)
            raise _Refused(vxi11.ERR_IO_TIMEOUT)
        answer = link.answers.popleft()
        length = min(len(answer), size, LONGEST_BYTES)
        reason = vxi11.RX_REQCNT if length == size else 0
        if length == len(answer):
            reason |= vxi11.RX_END
        else:
            link.answers.appendleft(answer[length:])
        head = NO_ERROR + struct.pack(">2I", reason, length)
        return head + answer[:length] + bytes(-length % 4)

    def _generic(self, action: Callable[[_Connection], None]) -> Procedure:
        def procedure(link: _Connection, arguments: bytes) -> bytes:
            self._check_access(link, *WORD.unpack_from(arguments))
            action(link)
            return NO_ERROR

        return procedure

    def _clear(self, link: _Connection) -> None:
        support = self._device.clear()
        if support is ClearSupport.NO_PROCEDURE:
            raise _Unavailable
        if support is ClearSupport.ERROR_8:
            raise _Refused(vxi11.ERR_OPERATION_NOT_SUPPORTED)
        link.incoming.clear()
        link.answers.clear()
        link.late.clear()

    def _take_lock(self, link: _Connection) -> None:
        with self._changing:
            if self._lock_holder is not None:  # it does not nest
                raise _Refused(vxi11.ERR_DEVICE_LOCKED_BY_ANOTHER_LINK)
            self._lock_holder = link

    def _unlock(self, link: _Connection) -> None:
        with self._changing:
            if self._lock_holder is not link:
                raise _Refused(vxi11.ERR_NO_LOCK_HELD_BY_THIS_LINK)
            self._lock_holder = None

    def _remove(self, link: _Connection) -> None:
        with self._changing:
            self._linked.discard(link)
            if self._lock_holder is link:
                self._unlock(link)

    def _check_access(self, link: _Connection, number: int) -> None:
        """Refuse a link that there is not, or while another one holds the lock: nobody waits."""
        with self._changing:
            if link not in self._linked or link.link != number:
                raise _Refused(vxi11.ERR_INVALID_LINK_IDENTIFIER)
            if self._lock_holder not in (None, link):
                raise _Refused(vxi11.ERR_DEVICE_LOCKED_BY_ANOTHER_LINK)

    def _suffer(self, fault: NetworkFault) -> None:
        """Do to the network what the device's fault does to it; then there is no reply."""
        if fault is NetworkFault.DROP_CONNECTIONS:
            self.drop_connections()
        if fault not in (NetworkFault.NONE, NetworkFault.ANSWER_LATE):
            raise _NoReply

    def _get_port(self, _connection: _Connection, arguments: bytes) -> bytes:
        program, _version, protocol = struct.unpack_from(">3I", arguments)
        is_known = (program, protocol) == (vxi11.DEVICE_CORE_PROG, rpc.IPPROTO_TCP)
        return WORD.pack(self.port if is_known else 0)
