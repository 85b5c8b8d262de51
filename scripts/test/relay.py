"""Carries TCP connections of one network namespace into another, through a socket in a folder.

usage: relay.py in|out PORT PATH

`in` listens on a port of loopback and passes each connection on to the socket at PATH; `out`
listens at PATH and passes each on to the port of its own loopback.
"""

from __future__ import annotations

import asyncio
import sys

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


async def main(direction, port, path):
    """Listen until the process is ended."""

    async def connect(reader, writer):
        if direction == "in":
            far_reader, far_writer = await asyncio.open_unix_connection(path)
        else:
            far_reader, far_writer = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.gather(carry(reader, far_writer), carry(far_reader, writer))

    if direction == "in":
        server = await asyncio.start_server(connect, "127.0.0.1", port)
    else:
        server = await asyncio.start_unix_server(connect, path)
    async with server:
        await server.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2]), sys.argv[3]))
