"""Calls and replies of ONC RPC version 2 (RFC 5531) in XDR (RFC 4506), without the network."""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass
from typing import Callable, Mapping, Optional, Protocol

_UINT = struct.Struct(">I")
_INT = struct.Struct(">i")
RPC_VERSION = 2
LONGEST_CREDENTIAL = 400
NULL_PROCEDURE = 0
AUTH_NONE = bytes(8)


class XdrError(ValueError):
    """The bytes are not what the protocol says should stand here."""


def pack_uint(value: int) -> bytes:
    """Return an unsigned integer of 32 bits."""
    return _UINT.pack(value)


def pack_int(value: int) -> bytes:
    """Return a signed integer of 32 bits."""
    return _INT.pack(value)


def pack_opaque(data: bytes) -> bytes:
    """Return variable-length data: length, bytes, zeros up to a multiple of four."""
    return _UINT.pack(len(data)) + data + b"\0" * (-len(data) % 4)


class ProcedureUnavailable(Exception):
    """A procedure acts as if the program did not have it."""


class XdrReader:
    """Takes one item after the other from received bytes."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._place = 0

    @property
    def remaining(self) -> int:
        """Number of bytes not taken yet."""
        return len(self._data) - self._place

    def uint(self) -> int:
        """Take an unsigned integer of 32 bits."""
        return self._number(_UINT)

    def sint(self) -> int:
        """Take a signed integer of 32 bits."""
        return self._number(_INT)

    def bool(self) -> bool:
        """Take a truth value; any number but zero is true, as clients differ."""
        return self.uint() != 0

    def opaque(self, longest: int) -> bytes:
        """Take variable-length data.

        Raises:
            XdrError: It is longer than `longest` bytes, or than what is there.
        """
        length = self.uint()
        if length > longest:
            raise XdrError(f"data of {length} bytes where at most {longest} are allowed")
        data = self._take(length)
        self._take(-length % 4)
        return data

    def skip(self, data: bytes) -> bool:
        """Take these bytes if they are next; return whether they are."""
        found = self._data.startswith(data, self._place)
        if found:
            self._place += len(data)
        return found

    def _number(self, form: struct.Struct) -> int:
        try:
            (number,) = form.unpack_from(self._data, self._place)
        except struct.error:
            raise XdrError(f"a number expected where {self.remaining} bytes remain") from None
        self._place += form.size
        return int(number)

    def _take(self, length: int) -> bytes:
        if length > self.remaining:
            raise XdrError(f"{length} bytes expected where {self.remaining} remain")
        start = self._place
        self._place += length
        return self._data[start : self._place]


class MessageType(enum.IntEnum):
    """First word after a message's number."""

    CALL = 0
    REPLY = 1


class ReplyStatus(enum.IntEnum):
    """Whether a call was looked at."""

    ACCEPTED = 0
    DENIED = 1


class AcceptStatus(enum.IntEnum):
    """What became of an accepted call."""

    SUCCESS = 0
    PROGRAM_UNAVAILABLE = 1
    PROGRAM_MISMATCH = 2
    PROCEDURE_UNAVAILABLE = 3
    GARBAGE_ARGUMENTS = 4


class Caller(Protocol):
    """The connection that a call came through."""

    def is_gone(self) -> bool:
        """Return whether the client has closed the connection."""


REPLY = pack_uint(MessageType.REPLY)
ACCEPTED = pack_uint(ReplyStatus.ACCEPTED) + AUTH_NONE
SUCCESS = pack_uint(AcceptStatus.SUCCESS)

# Takes the arguments and the caller; returns the result, or None for no reply at all.
Procedure = Callable[[XdrReader, Caller], Optional[bytes]]


@dataclass(frozen=True)
class RpcProgram:
    """A program that clients can call; procedure 0 answers by itself."""

    number: int
    version: int
    procedures: Mapping[int, Procedure]


@dataclass(frozen=True)
class _Call:
    number: int
    version: int
    procedure: int


def answer_call(program: RpcProgram, message: bytes, caller: Caller) -> Optional[bytes]:
    """Return the reply to one message; None if there is to be none.

    Raises:
        XdrError: The message is not even the head of a call.
    """
    reader = XdrReader(message)
    xid = reader.uint()
    if reader.uint() != MessageType.CALL:
        raise XdrError("a message that is not a call")
    head = pack_uint(xid) + REPLY
    if reader.uint() != RPC_VERSION:
        # Denied, because of the RPC version: lowest and highest version understood.
        return head + b"".join(map(pack_uint, (ReplyStatus.DENIED, 0, RPC_VERSION, RPC_VERSION)))
    call = _Call(reader.uint(), reader.uint(), reader.uint())
    # Almost every client sends neither a credential nor a verifier.
    if not reader.skip(2 * AUTH_NONE):
        for _credential_then_verifier in range(2):
            reader.uint()
            reader.opaque(LONGEST_CREDENTIAL)
    outcome = _outcome(program, call, reader, caller)
    if outcome is None:
        return None
    return head + ACCEPTED + outcome


def _outcome(
    program: RpcProgram, call: _Call, arguments: XdrReader, caller: Caller
) -> Optional[bytes]:
    if call.number != program.number:
        return pack_uint(AcceptStatus.PROGRAM_UNAVAILABLE)
    if call.version != program.version:
        lowest_and_highest = 2 * pack_uint(program.version)
        return pack_uint(AcceptStatus.PROGRAM_MISMATCH) + lowest_and_highest
    if call.procedure == NULL_PROCEDURE:
        return pack_uint(AcceptStatus.SUCCESS)
    procedure = program.procedures.get(call.procedure)
    if procedure is None:
        return pack_uint(AcceptStatus.PROCEDURE_UNAVAILABLE)
    try:
        result = procedure(arguments, caller)
    except XdrError:
        return pack_uint(AcceptStatus.GARBAGE_ARGUMENTS)
    except ProcedureUnavailable:
        return pack_uint(AcceptStatus.PROCEDURE_UNAVAILABLE)
    return None if result is None else SUCCESS + result
