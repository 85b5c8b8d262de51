"""The DT1 files of Sensors & Software, with their text header HD beside them.

A trace is 25 little-endian floats and a comment of 28 bytes, then its samples: 16-bit integers, or
floats in files of newer instruments (pulseEKKO user's guide, "Data file format").
"""

from __future__ import annotations

from pathlib import Path
from typing import Dict

import numpy as np

from gpr20_analysis.formats.format import ImportOptions
from gpr20_common.message import Message
from gpr20_foreign_formats.header import content_of, sibling, text_header, trace_count
from gpr20_foreign_formats.traces import Traces, format_of

HEADER_FLOATS = 32  # with the comment
POSITION, SAMPLES, ZERO_FLAG = 1, 2, 21  # places in the header of a trace; 21 is item 22
TYPES: Dict[int, str] = {2: "<i2", 4: "<f4"}
METRES = {"M": 1.0, "METRES": 1.0, "METERS": 1.0, "FT": 0.3048, "FEET": 0.3048}
LONGEST_NS = 1e6


def read_dt1(path: Path, _: ImportOptions) -> Traces:
    """Read a line; TIMEZERO AT POINT is counted from 0, so it may be off by a sample.

    Raises:
        UnreadableFileError: A file is missing, a header is wrong, or the file was cut off.
    """
    data, header = sibling(path, ".dt1"), text_header(sibling(path, ".hd"), "=")
    count = header.count("NUMBER OF TRACES", 1, 1 << 24)
    samples = header.count("NUMBER OF PTS/TRC", 2, 1 << 16)
    step_s = 1e-9 * header.number("TOTAL TIME WINDOW", 1e-3, LONGEST_NS) / samples
    unit = str(header.entries.get("POSITION UNITS")).upper()
    if unit not in METRES:
        raise header.refused("POSITION UNITS", Message("m or ft"))
    content = content_of(data)
    # The samples have 2 or 4 bytes; the number in the traces is 0 in old files.
    width = 4 if len(content) == 4 * count * (HEADER_FLOATS + samples) else 2
    layout = np.dtype([("header", "<f4", HEADER_FLOATS), ("values", TYPES[width], samples)])
    found = trace_count(data, len(content), layout.itemsize)
    traces = np.frombuffer(content, layout)
    for key, values in (
        ("NUMBER OF TRACES", np.array([found])),
        ("NUMBER OF PTS/TRC", traces["header"][:, SAMPLES]),
    ):
        other = values[values != header.number(key, 0, np.inf)]
        if other.size:
            as_in = {"count": float(other[0]), "file": data.name}
            raise header.refused(key, Message("{count:g}, as in {file}", **as_in))
    scans = traces["values"].astype(np.float64)
    scans[traces["header"][:, ZERO_FLAG] == 1.0] = np.nan  # zero data: not measured
    return Traces(
        data,
        scans,
        step_s=step_s,
        zero_s=step_s * header.number("TIMEZERO AT POINT", 0.0, samples, 0.0),
        x_m=traces["header"][:, POSITION].astype(np.float64) * METRES[unit],
        separation_m=METRES[unit] * header.number("ANTENNA SEPARATION", 0.0, 1e3, 0.0) or None,
    )


IMPORT = format_of(read_dt1, ".dt1", ".hd")
