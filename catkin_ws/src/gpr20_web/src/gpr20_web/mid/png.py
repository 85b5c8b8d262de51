"""Pictures of numbers, each of which has a colour, as PNG files."""

from __future__ import annotations

import struct
import zlib

import numpy as np

# The fastest compression: a picture is looked at for a second.
BITS, PALETTE, COMPRESSION = 8, 3, 1


def png(numbers: np.ndarray, colours: np.ndarray) -> bytes:
    """Return a picture.

    Args:
        numbers: Number of the colour of each pixel, row by row from the top (uint8).
        colours: Red, green, blue and alpha of each number (uint8, at most 256 x 4).
    """
    height, width = numbers.shape
    # Each row begins with the number of its filter, which is none.
    rows = np.pad(numbers, ((0, 0), (1, 0)))
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, BITS, PALETTE, 0, 0, 0)),
        (b"PLTE", colours[:, :3].tobytes()),
        (b"tRNS", colours[:, 3].tobytes()),
        (b"IDAT", zlib.compress(rows.tobytes(), COMPRESSION)),
        (b"IEND", b""),
    )
    parts = [b"\x89PNG\r\n\x1a\n"]
    for kind, content in chunks:
        sum_ = zlib.crc32(kind + content)
        parts += [struct.pack(">I", len(content)), kind, content, struct.pack(">I", sum_)]
    return b"".join(parts)
