"""Numbers of VXI-11 (revision 1.0) and the layouts of its calls and replies."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from gpr20_simulator.low.rpc import XdrReader, pack_int, pack_opaque, pack_uint

CORE_PROGRAM = 0x0607AF
ABORT_PROGRAM = 0x0607B0
VERSION = 1
LONGEST_DEVICE_NAME = 256
SMALLEST_RECEIVE_SIZE = 1024

DEVICE_ABORT = 1


class CoreProcedure(enum.IntEnum):
    """Procedures of the core channel."""

    CREATE_LINK = 10
    DEVICE_WRITE = 11
    DEVICE_READ = 12
    DEVICE_READSTB = 13
    DEVICE_TRIGGER = 14
    DEVICE_CLEAR = 15
    DEVICE_REMOTE = 16
    DEVICE_LOCAL = 17
    DEVICE_LOCK = 18
    DEVICE_UNLOCK = 19
    DEVICE_ENABLE_SRQ = 20
    DEVICE_DOCMD = 22
    DESTROY_LINK = 23
    CREATE_INTR_CHAN = 25
    DESTROY_INTR_CHAN = 26


class Error(enum.IntEnum):
    """Error codes of the replies."""

    NONE = 0
    DEVICE_NOT_ACCESSIBLE = 3
    INVALID_LINK = 4
    PARAMETER = 5
    NOT_SUPPORTED = 8
    OUT_OF_RESOURCES = 9
    LOCKED_BY_ANOTHER = 11
    NO_LOCK_HELD = 12
    IO_TIMEOUT = 15
    IO_ERROR = 17
    ABORTED = 23


class Flag(enum.IntEnum):
    """Flags of a call."""

    WAIT_LOCK = 1
    END = 8
    TERMINATION_CHARACTER = 128


class Reason(enum.IntEnum):
    """Why a read ended."""

    NONE = 0
    REQUEST_COUNT = 1
    CHARACTER = 2
    END = 4


@dataclass(frozen=True)
class WriteCall:
    """Arguments of device_write."""

    link: int
    lock_timeout_s: float
    flags: int
    data: bytes

    @classmethod
    def read(cls, arguments: XdrReader, longest: int) -> WriteCall:
        """Take the arguments."""
        link = arguments.sint()
        arguments.uint()  # io_timeout: this server takes data at once
        lock_timeout_s = arguments.uint() / 1000.0
        return cls(link, lock_timeout_s, arguments.sint(), arguments.opaque(longest))


@dataclass(frozen=True)
class ReadCall:
    """Arguments of device_read."""

    link: int
    size: int
    io_timeout_s: float
    lock_timeout_s: float
    flags: int
    termination_character: bytes

    @classmethod
    def read(cls, arguments: XdrReader) -> ReadCall:
        """Take the arguments."""
        return cls(
            link=arguments.sint(),
            size=arguments.uint(),
            io_timeout_s=arguments.uint() / 1000.0,
            lock_timeout_s=arguments.uint() / 1000.0,
            flags=arguments.sint(),
            termination_character=bytes([arguments.sint() & 0xFF]),
        )


@dataclass(frozen=True)
class GenericCall:
    """Arguments of readstb, trigger, clear, remote and local."""

    link: int
    flags: int
    lock_timeout_s: float

    @classmethod
    def read(cls, arguments: XdrReader) -> GenericCall:
        """Take the arguments."""
        link, flags = arguments.sint(), arguments.sint()
        lock_timeout_s = arguments.uint() / 1000.0
        arguments.uint()  # io_timeout: none of these waits for the device
        return cls(link, flags, lock_timeout_s)


def link_reply(error: Error, link: int, abort_port: int, receive_size: int) -> bytes:
    """Return the reply of create_link."""
    return pack_int(error) + pack_int(link) + pack_uint(abort_port) + pack_uint(receive_size)


def read_reply(error: Error, reason: int, data: bytes) -> bytes:
    """Return the reply of device_read."""
    return pack_int(error) + pack_int(reason) + pack_opaque(data)
