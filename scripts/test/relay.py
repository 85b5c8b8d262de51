"""Carries TCP connections from a port of loopback of one network namespace to that of another.

usage: relay.py FROM TO PORT
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
import socket
import sys

PIECE_BYTES = 1 << 16
CLONE_NEWNET = 0x40000000  # <linux/sched.h>


def enter(namespace):
    """Let this process be in a namespace from now on."""
    with open(f"/run/netns/{namespace}") as file:
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.setns(file.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), namespace)


async def carry(reader, writer):
    """Carry one direction to its end; when the other side has gone, so has this connection."""
    with contextlib.suppress(ConnectionError), contextlib.closing(writer):
        while piece := await reader.read(PIECE_BYTES):
            writer.write(piece)
            await writer.drain()


async def main(source, target, port):
    """Listen until the process is ended."""

    async def connect(reader, writer):
        far_reader, far_writer = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.gather(carry(reader, far_writer), carry(far_reader, writer))

    enter(source)
    listening = socket.create_server(("127.0.0.1", port))
    # A socket stays in the namespace in which it was made.
    enter(target)
    async with await asyncio.start_server(connect, sock=listening) as server:
        await server.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], sys.argv[2], int(sys.argv[3])))
