"""External data representation (RFC 4506): the items that RPC and VXI-11 use."""

from __future__ import annotations

import struct

from gpr20_common.errors import Gpr20Error

_UINT = struct.Struct(">I")
_INT = struct.Struct(">i")


class XdrError(Gpr20Error, ValueError):
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
        return _UINT.unpack(self._take(4))[0]

    def sint(self) -> int:
        """Take a signed integer of 32 bits."""
        return _INT.unpack(self._take(4))[0]

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

    def _take(self, length: int) -> bytes:
        if length > self.remaining:
            raise XdrError(f"{length} bytes expected where {self.remaining} remain")
        start = self._place
        self._place += length
        return self._data[start : self._place]
