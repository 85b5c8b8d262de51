"""The files of MALA's radars: samples in RD3 (16 bit) or RD7 (32 bit), text header RAD beside."""

from __future__ import annotations

from pathlib import Path
from typing import Dict

import numpy as np

from gpr20_analysis.formats.imports import ImportOptions
from gpr20_foreign_formats.header import (
    content_of,
    partner,
    stale_count,
    text_header,
    trace_count,
    unread_beside,
)
from gpr20_foreign_formats.traces import Traces, format_of

BYTES: Dict[str, int] = {".rd3": 2, ".rd7": 4}
SAME = 0.02
"""How much TIMEWINDOW may differ from SAMPLES / FREQUENCY, as a share."""


def read_rd3(path: Path, _: ImportOptions) -> Traces:
    """Read a line of one channel, as shares of the full scale.

    SIGNAL POSITION is in units of the instrument, so time zero is not known.

    Raises:
        UnreadableFileError: A file is missing, the header is wrong, or the file was cut off.
    """
    data = partner(path, *BYTES)
    header = text_header(partner(path, ".rad"), ":", "RD3 (RAD)", "SAMPLES")
    header.number("NUMBER_OF_CH", 1, 1, 1)  # several channels are interleaved
    samples = header.count("SAMPLES", 2, 1 << 16)
    frequency_hz = 1e6 * header.number("FREQUENCY", 1.0, 1e7)
    window_ns = 1e9 * samples / frequency_hz
    header.number("TIMEWINDOW", (1 - SAME) * window_ns, (1 + SAME) * window_ns, window_ns)
    content, width = content_of(data), BYTES[data.suffix.lower()]
    count = trace_count(data, len(content), samples * width)
    by_time = header.entries.get("TIME FLAG") == "1" and header.entries.get("DISTANCE FLAG") != "1"
    # A wheel that turns the other way counts backwards.
    spacing_m = 0.0 if by_time else header.number("DISTANCE INTERVAL", -1e3, 1e3, 0.0)
    return Traces(
        data,
        np.frombuffer(content, f"<i{width}").reshape(count, samples) / 2.0 ** (8 * width - 1),
        step_s=1.0 / frequency_hz,
        x_m=np.arange(count) * spacing_m if spacing_m else None,
        separation_m=header.number("ANTENNA SEPARATION", 0.0, 1e3, 0.0) or None,
        notes=[
            *stale_count(header, "LAST TRACE", count),
            *unread_beside(data, ".cor", ".mrk", ".gps"),
        ],
    )


IMPORT = format_of(read_rd3, *BYTES, ".rad")
