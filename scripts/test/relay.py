"""Carries TCP connections from a port of loopback of one network namespace to that of another.

usage: relay.py FROM TO PORT
"""

from __future__ import annotations

import asyncio
import socket
import sys

from bad_link import enter

PIECE_BYTES = 1 << 16


async def carry(reader, writer):
    """Carry one direction to its end."""
    try:
        while True:
            piece = await reader.read(PIECE_BYTES)
            if not piece:
                break
            writer.write(piece)
            await writer.drain()
    except ConnectionError:
        pass  # the other side has gone: so has this connection
    finally:
        writer.close()


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
