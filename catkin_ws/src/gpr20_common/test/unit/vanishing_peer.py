"""Connections whose other end can vanish without closing them, as if its cable was pulled."""

import ctypes
import socket
import struct

# From <asm-generic/socket.h> and <linux/filter.h>: a filter that lets no byte of a packet pass
# makes the kernel drop what arrives, unanswered.
SO_ATTACH_FILTER, SO_DETACH_FILTER = 26, 27
DROP_ALL = struct.pack("=HBBI", 0x06, 0, 0, 0)


def vanish(end):
    """Drop everything that arrives at this end of a connection from now on."""
    program = ctypes.create_string_buffer(DROP_ALL, len(DROP_ALL))
    end.setsockopt(
        socket.SOL_SOCKET, SO_ATTACH_FILTER, struct.pack("@HP", 1, ctypes.addressof(program))
    )


def come_back(end):
    """Let everything arrive again."""
    end.setsockopt(socket.SOL_SOCKET, SO_DETACH_FILTER, 0)
