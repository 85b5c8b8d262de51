"""Lines with a text header beside them: DT1 of Sensors & Software, RD3 and RD7 of MALA.

A trace of DT1 is 25 little-endian floats and a comment of 28 bytes, then its samples: 16-bit
integers, or floats in files of newer instruments (pulseEKKO user's guide, "Data file format").
Samples of RD3 have 16 bits, those of RD7 32 bits.
"""

from __future__ import annotations

from pathlib import Path
from typing import Dict

import numpy as np

from gpr20_analysis.formats.imports import ImportOptions
from gpr20_common.message import Message
from gpr20_foreign_formats.header import (
    Header,
    content_of,
    partner,
    stale_count,
    text_header,
    trace_count,
    unread_beside,
)
from gpr20_foreign_formats.traces import Traces, format_of

HEADER_FLOATS = 32  # with the comment
# Places in the header of a trace, by the manual's items, which count from 1.
POSITION, SAMPLES, BYTES, ADJUSTMENT, ZERO_FLAG = 1, 2, 5, 20, 21
METRES: Dict[str, float] = {"M": 1.0, "METRES": 1.0, "METERS": 1.0, "FT": 0.3048, "FEET": 0.3048}
LONGEST_NS = 1e6
MODE, LINE = "SURVEY MODE", "REFLECTION"
WIDTHS: Dict[str, int] = {".rd3": 2, ".rd7": 4}
SAME = 0.02
"""How much TIMEWINDOW may differ from SAMPLES / FREQUENCY, as a share."""


def read_dt1(path: Path, _: ImportOptions) -> Traces:
    """Read a line; TIMEZERO AT POINT counts from 1, and is 0 or missing if nobody has set it.

    Raises:
        UnreadableFileError: A file is missing, a header is wrong, the file was cut off, or the
            antennas were not moved together.
    """
    data = partner(path, ".dt1")
    header = text_header(partner(path, ".hd"), "=", "DT1 (HD)", "NUMBER OF PTS/TRC")
    if header.entries.get(MODE, LINE).upper() != LINE:
        together = Message("Reflection, antennas that move together along a line")
        raise header.refused(MODE, together)
    samples = header.count("NUMBER OF PTS/TRC", 2, 1 << 16)
    window_ns = header.number("TOTAL TIME WINDOW", 1e-3, LONGEST_NS)
    unit = str(header.entries.get("POSITION UNITS")).upper()
    if unit not in METRES:
        raise header.refused("POSITION UNITS", Message("m or ft"))
    content, said = content_of(data), header.number("NUMBER OF TRACES", 0, np.inf, 0)
    # The number of bytes in the traces is 0 in old files.
    stated = np.frombuffer(content[: 4 * HEADER_FLOATS].ljust(4 * HEADER_FLOATS, b"\0"), "<f4")
    is_long = len(content) == 4 * said * (HEADER_FLOATS + samples) or stated[BYTES] == 4.0
    kind = "<f4" if is_long else "<i2"
    layout = np.dtype([("header", "<f4", HEADER_FLOATS), ("values", kind, samples)])
    found = trace_count(data, len(content), layout.itemsize)
    traces = np.frombuffer(content, layout)
    own = traces["header"].T
    for key, entry, expected in (
        ("NUMBER OF PTS/TRC", own[SAMPLES], samples),
        ("TIMEZERO ADJUSTMENT", own[ADJUSTMENT], 0),
    ):
        other = entry[entry != expected]
        if other.size:
            in_traces = Header(data.name, {key: f"{other[0]:g}"})
            raise in_traces.refused(key, Message("{expected} in each trace", expected=expected))
    scans = traces["values"].astype(np.float64)
    scans[own[ZERO_FLAG] == 1.0] = np.nan  # zero data: not measured
    step_s = 1e-9 * window_ns / samples
    point = header.number("TIMEZERO AT POINT", 0.0, samples, 0.0)
    return Traces(
        data,
        scans,
        step_s=step_s,
        zero_s=step_s * max(point - 1.0, 0.0) if point else None,
        x_m=own[POSITION].astype(np.float64) * METRES[unit],
        separation_m=METRES[unit] * header.number("ANTENNA SEPARATION", 0.0, 1e3, 0.0) or None,
        notes=[
            *stale_count(header, "NUMBER OF TRACES", found),
            *unread_beside(data, ".gps", ".gp2", ".top"),
        ],
    )


DT1 = format_of(read_dt1, ".dt1", ".hd")


def read_rd3(path: Path, _: ImportOptions) -> Traces:
    """Read a line of one channel, as shares of the full scale.

    SIGNAL POSITION is in units of the instrument, so time zero is not known.

    Raises:
        UnreadableFileError: A file is missing, the header is wrong, or the file was cut off.
    """
    data = partner(path, *WIDTHS)
    header = text_header(partner(path, ".rad"), ":", "RD3 (RAD)", "SAMPLES")
    header.number("NUMBER_OF_CH", 1, 1, 1)  # several channels are interleaved
    samples = header.count("SAMPLES", 2, 1 << 16)
    frequency_hz = 1e6 * header.number("FREQUENCY", 1.0, 1e7)
    window_ns = 1e9 * samples / frequency_hz
    header.number("TIMEWINDOW", (1 - SAME) * window_ns, (1 + SAME) * window_ns, window_ns)
    content, width = content_of(data), WIDTHS[data.suffix.lower()]
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


RD3 = format_of(read_rd3, *WIDTHS, ".rad")
