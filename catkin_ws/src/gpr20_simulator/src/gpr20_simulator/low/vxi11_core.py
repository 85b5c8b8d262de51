"""The core channel of VXI-11: what each procedure does to a device and its links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional, Tuple

from gpr20_common.mid.checks import number_between
from gpr20_simulator.low import vxi11_protocol as protocol
from gpr20_simulator.low.message_device import ClearSupport, MessageDevice, NetworkFault
from gpr20_simulator.low.rpc import (
    Caller,
    Procedure,
    ProcedureUnavailable,
    RpcProgram,
    XdrReader,
    pack_int,
    pack_opaque,
    pack_uint,
)
from gpr20_simulator.low.vxi11_links import Link, LinkBook, LinkError
from gpr20_simulator.low.vxi11_protocol import CoreProcedure, Error, Flag, Reason

DEVICE_NAME = b"inst0"
MESSAGE_AVAILABLE = 0x10


@dataclass(frozen=True)
class Limits:
    """What the server bears.

    Attributes:
        receive_size: Longest data of one device_write [bytes]; more get an error.
        record_size: Longest call [bytes]; a longer one ends the connection.
        reply_size: Longest data of one device_read [bytes].
        message_size: Longest message put together from several writes [bytes].
        links: Number of links at a time.
        connections: Number of connections to each channel at a time.
    """

    receive_size: int = 65536
    record_size: int = 1 << 20
    reply_size: int = 1 << 20
    message_size: int = 1 << 20
    links: int = 16
    connections: int = 32

    def __post_init__(self) -> None:
        """Refuse a receive size below what the standard demands."""
        smallest = protocol.SMALLEST_RECEIVE_SIZE
        number_between("receive_size", self.receive_size, smallest, 1 << 30, "bytes")


class CoreChannel:
    """The procedures of the core channel, for any number of connections.

    Args:
        device: What is served, as `inst0`.
        links: The links of all connections.
        limits: What the server bears.
        abort_port: Port of the abort channel, sent to each client.
        misbehave: Called when the device wants the network to fail; no reply follows.
    """

    def __init__(
        self,
        device: MessageDevice,
        links: LinkBook,
        limits: Limits,
        abort_port: int,
        misbehave: Callable[[NetworkFault], None],
    ) -> None:
        self._device = device
        self._links = links
        self._limits = limits
        self._abort_port = abort_port
        self._misbehave = misbehave

    def program(self) -> RpcProgram:
        """Return the program that clients call."""
        device = self._device
        return RpcProgram(
            protocol.CORE_PROGRAM,
            protocol.VERSION,
            {
                CoreProcedure.CREATE_LINK: self._create_link,
                CoreProcedure.DEVICE_WRITE: self._device_write,
                CoreProcedure.DEVICE_READ: self._device_read,
                CoreProcedure.DEVICE_READSTB: self._device_readstb,
                CoreProcedure.DEVICE_TRIGGER: self._generic(_unsupported),
                CoreProcedure.DEVICE_CLEAR: self._generic(self._clear),
                CoreProcedure.DEVICE_REMOTE: self._generic(lambda _l: device.set_remote(True)),
                CoreProcedure.DEVICE_LOCAL: self._generic(lambda _l: device.set_remote(False)),
                CoreProcedure.DEVICE_LOCK: self._device_lock,
                CoreProcedure.DEVICE_UNLOCK: self._device_unlock,
                CoreProcedure.DEVICE_ENABLE_SRQ: self._device_enable_srq,
                CoreProcedure.DEVICE_DOCMD: self._device_docmd,
                CoreProcedure.DESTROY_LINK: self._destroy_link,
                CoreProcedure.CREATE_INTR_CHAN: _no_interrupt_channel,
                CoreProcedure.DESTROY_INTR_CHAN: _no_interrupt_channel,
            },
        )

    def _create_link(self, arguments: XdrReader, caller: Caller) -> Optional[bytes]:
        arguments.sint()  # the client's own number for itself
        wants_lock, lock_timeout_s = arguments.bool(), arguments.uint() / 1000.0
        name = arguments.opaque(protocol.LONGEST_DEVICE_NAME)
        if name.lower() != DEVICE_NAME:
            return protocol.link_reply(Error.DEVICE_NOT_ACCESSIBLE, 0, 0, 0)
        fault = self._device.opened()
        if fault is not NetworkFault.NONE:
            self._misbehave(fault)
            return None
        try:
            link = self._links.create(caller, lock_timeout_s if wants_lock else None)
        except LinkError as error:
            return protocol.link_reply(error.code, 0, 0, 0)
        return protocol.link_reply(
            Error.NONE, link.number, self._abort_port, self._limits.receive_size
        )

    def _device_write(self, arguments: XdrReader, caller: Caller) -> Optional[bytes]:
        call = protocol.WriteCall.read(arguments, self._limits.record_size)
        try:
            with self._links.call(call.link, caller) as link:
                self._links.check_access(link, call.flags, call.lock_timeout_s)
                self._gather(link, call.data)
                fault = self._execute(link) if call.flags & Flag.END else NetworkFault.NONE
        except LinkError as error:
            return pack_int(error.code) + pack_uint(0)
        if fault is not NetworkFault.NONE:
            self._misbehave(fault)
            return None
        return pack_int(Error.NONE) + pack_uint(len(call.data))

    def _gather(self, link: Link, data: bytes) -> None:
        if len(data) > self._limits.receive_size:
            raise LinkError(Error.PARAMETER)
        if len(link.incoming) + len(data) > self._limits.message_size:
            link.incoming.clear()
            raise LinkError(Error.OUT_OF_RESOURCES)
        link.incoming += data

    def _execute(self, link: Link) -> NetworkFault:
        message = bytes(link.incoming)
        link.incoming.clear()
        outcome = self._device.execute(message)
        for answer in link.late:
            link.queue(answer)
        link.late.clear()
        if outcome.fault is NetworkFault.ANSWER_LATE:
            link.late.append(outcome.answer)
            return NetworkFault.NONE
        if outcome.answer:
            link.queue(outcome.answer)
        return outcome.fault

    def _device_read(self, arguments: XdrReader, caller: Caller) -> bytes:
        call = protocol.ReadCall.read(arguments)
        try:
            with self._links.call(call.link, caller) as link:
                self._links.check_access(link, call.flags, call.lock_timeout_s)
                if call.size == 0:
                    return protocol.read_reply(Error.NONE, Reason.REQUEST_COUNT, b"")
                self._links.wait_for_answer(link, call.io_timeout_s)
                reason, data = self._take_answer(link, call)
        except LinkError as error:
            return protocol.read_reply(error.code, Reason.NONE, b"")
        return protocol.read_reply(Error.NONE, reason, data)

    def _take_answer(self, link: Link, call: protocol.ReadCall) -> Tuple[int, bytes]:
        answer = link.outgoing.popleft()
        length = min(len(answer), call.size, self._limits.reply_size)
        reason: int = Reason.NONE
        if call.flags & Flag.TERMINATION_CHARACTER:
            place = answer.find(call.termination_character, 0, length)
            if place >= 0:
                length, reason = place + 1, Reason.CHARACTER
        if length == call.size:
            reason |= Reason.REQUEST_COUNT
        if length == len(answer):
            reason |= Reason.END
        else:
            link.outgoing.appendleft(answer[length:])
        return int(reason), answer[:length]

    def _device_readstb(self, arguments: XdrReader, caller: Caller) -> bytes:
        call = protocol.GenericCall.read(arguments)
        try:
            with self._links.call(call.link, caller) as link:
                self._links.check_access(link, call.flags, call.lock_timeout_s)
                status_byte = MESSAGE_AVAILABLE if link.outgoing else 0
        except LinkError as error:
            return pack_int(error.code) + pack_uint(0)
        return pack_int(Error.NONE) + pack_uint(status_byte)

    def _generic(self, action: Callable[[Link], None]) -> Procedure:
        def procedure(arguments: XdrReader, caller: Caller) -> bytes:
            call = protocol.GenericCall.read(arguments)

            def with_access(link: Link) -> None:
                self._links.check_access(link, call.flags, call.lock_timeout_s)
                action(link)

            return self._on_link(call.link, caller, with_access)

        return procedure

    def _clear(self, link: Link) -> None:
        support = self._device.clear()
        if support is ClearSupport.NO_PROCEDURE:
            raise ProcedureUnavailable
        if support is ClearSupport.ERROR_8:
            raise LinkError(Error.NOT_SUPPORTED)
        link.incoming.clear()
        link.outgoing.clear()
        link.late.clear()

    def _device_lock(self, arguments: XdrReader, caller: Caller) -> bytes:
        number, flags = arguments.sint(), arguments.sint()
        lock_timeout_s = arguments.uint() / 1000.0
        return self._on_link(
            number, caller, lambda link: self._links.lock(link, flags, lock_timeout_s)
        )

    def _device_unlock(self, arguments: XdrReader, caller: Caller) -> bytes:
        return self._on_link(arguments.sint(), caller, self._links.unlock)

    def _destroy_link(self, arguments: XdrReader, caller: Caller) -> bytes:
        return self._on_link(arguments.sint(), caller, self._links.destroy)

    def _device_enable_srq(self, arguments: XdrReader, caller: Caller) -> bytes:
        return self._on_link(arguments.sint(), caller, _unsupported)

    def _device_docmd(self, arguments: XdrReader, caller: Caller) -> bytes:
        try:
            with self._links.call(arguments.sint(), caller):
                return pack_int(Error.NOT_SUPPORTED) + pack_opaque(b"")
        except LinkError as error:
            return pack_int(error.code) + pack_opaque(b"")

    def _on_link(self, number: int, caller: Caller, action: Callable[[Link], None]) -> bytes:
        try:
            with self._links.call(number, caller) as link:
                action(link)
        except LinkError as error:
            return pack_int(error.code)
        return pack_int(Error.NONE)


def _unsupported(_link: Link) -> None:
    raise LinkError(Error.NOT_SUPPORTED)


def _no_interrupt_channel(_arguments: XdrReader, _caller: Caller) -> bytes:
    return pack_int(Error.NOT_SUPPORTED)
