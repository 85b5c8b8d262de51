"""The calls and replies of every exchange, packed as python-vxi11 packs them, but in one piece.

The library packs each number by itself, which took a third of the driver's processor time. All
calls that are not made for every exchange, and all replies but those of a success, are left to it.
"""

from __future__ import annotations

import struct
from typing import Any, Tuple

from vxi11 import rpc, vxi11

NO_AUTHENTICATION = (rpc.AUTH_NULL, b"")
# Number, kind and version of the RPC; program, its version and the procedure; two empty
# authentications of a kind and a length each.
CALL_HEAD = struct.Struct(">10I")
# Link, two time limits [ms], flags; number of bytes that follow.
WRITE_CALL = struct.Struct(">iIIiI")
# Link, number of bytes, two time limits [ms], flags, termination character.
READ_CALL = struct.Struct(">iIIIii")
NUMBER = struct.Struct(">I")
# What follows the number of a reply: it is one, accepted, with an empty authentication, a success.
SUCCESS = struct.pack(">5I", rpc.REPLY, rpc.MSG_ACCEPTED, rpc.AUTH_NULL, 0, rpc.SUCCESS)
SUCCESS_HEAD_BYTES = NUMBER.size + len(SUCCESS)


class Packer(vxi11.Packer):  # type: ignore[misc]
    """Packs calls."""

    def pack_callheader(
        self, xid: int, prog: int, vers: int, proc: int, cred: Any, verf: Any
    ) -> None:
        """Pack the head of any call."""
        if cred != NO_AUTHENTICATION or verf != NO_AUTHENTICATION:
            super().pack_callheader(xid, prog, vers, proc, cred, verf)
            return
        head = (xid, rpc.CALL, rpc.RPCVERSION, prog, vers, proc, 0, 0, 0, 0)
        self.pack_fopaque(CALL_HEAD.size, CALL_HEAD.pack(*head))

    def pack_device_write_parms(self, params: Tuple[int, int, int, int, bytes]) -> None:
        """Pack the arguments of `device_write`."""
        *numbers, data = params
        packed = WRITE_CALL.pack(*numbers, len(data)) + data
        self.pack_fopaque(len(packed), packed)

    def pack_device_read_parms(self, params: Tuple[int, int, int, int, int, int]) -> None:
        """Pack the arguments of `device_read`."""
        self.pack_fopaque(READ_CALL.size, READ_CALL.pack(*params))


class Unpacker(vxi11.Unpacker):  # type: ignore[misc]
    """Unpacks replies."""

    def unpack_replyheader(self) -> Tuple[int, Any]:
        """Unpack the head of a reply; raise if it is not that of a success."""
        reply = self.get_buffer()
        if reply[NUMBER.size : SUCCESS_HEAD_BYTES] != SUCCESS:
            verified: Tuple[int, Any] = super().unpack_replyheader()
            return verified
        self.set_position(SUCCESS_HEAD_BYTES)
        return NUMBER.unpack_from(reply)[0], NO_AUTHENTICATION
