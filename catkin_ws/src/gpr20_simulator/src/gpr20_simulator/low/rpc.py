"""Calls and replies of ONC RPC version 2 (RFC 5531), without the network."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Callable, Mapping, Optional, Protocol, Sequence

from gpr20_simulator.low.xdr import XdrError, XdrReader, pack_uint

RPC_VERSION = 2
LONGEST_CREDENTIAL = 400
NULL_PROCEDURE = 0
AUTH_NONE = pack_uint(0) + pack_uint(0)


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


def answer_call(programs: Sequence[RpcProgram], message: bytes, caller: Caller) -> Optional[bytes]:
    """Return the reply to one message; None if there is to be none.

    Raises:
        XdrError: The message is not even the head of a call.
    """
    reader = XdrReader(message)
    xid = reader.uint()
    if reader.uint() != MessageType.CALL:
        raise XdrError("a message that is not a call")
    head = pack_uint(xid) + pack_uint(MessageType.REPLY)
    if reader.uint() != RPC_VERSION:
        # Denied, because of the RPC version: lowest and highest version understood.
        return head + b"".join(map(pack_uint, (ReplyStatus.DENIED, 0, RPC_VERSION, RPC_VERSION)))
    call = _Call(reader.uint(), reader.uint(), reader.uint())
    for _credential_then_verifier in range(2):
        reader.uint()
        reader.opaque(LONGEST_CREDENTIAL)
    outcome = _outcome(programs, call, reader, caller)
    if outcome is None:
        return None
    return head + pack_uint(ReplyStatus.ACCEPTED) + AUTH_NONE + outcome


def _outcome(
    programs: Sequence[RpcProgram], call: _Call, arguments: XdrReader, caller: Caller
) -> Optional[bytes]:
    offered = [one for one in programs if one.number == call.number]
    if not offered:
        return pack_uint(AcceptStatus.PROGRAM_UNAVAILABLE)
    program = next((one for one in offered if one.version == call.version), None)
    if program is None:
        versions = [one.version for one in offered]
        lowest_and_highest = pack_uint(min(versions)) + pack_uint(max(versions))
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
    return None if result is None else pack_uint(AcceptStatus.SUCCESS) + result
