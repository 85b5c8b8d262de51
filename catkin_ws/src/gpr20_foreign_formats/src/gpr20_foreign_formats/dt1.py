"""The DT1 files of Sensors & Software, with their text header HD beside them.

A trace is 25 little-endian floats and a comment of 28 bytes, then its samples: 16-bit integers, or
from pulseEKKO Ultra on floats (pulseEKKO user's guide, "Data file format").
"""

from __future__ import annotations

from pathlib import Path
from typing import Dict, Optional

import numpy as np
import xarray as xr

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.format import ImportFormat, ImportOptions
from gpr20_analysis.progress import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.header_numbers import (
    Numbers,
    content_of,
    require_beside,
    text_entries,
    trace_count,
)
from gpr20_foreign_formats.traces import TRACES, Traces, as_survey

HEADER_FLOATS = 32  # the comment included
HEADER_BYTES = 4 * HEADER_FLOATS
POSITION, SAMPLES, SAMPLE_BYTES = 1, 2, 5  # places in the header of a trace
TYPES: Dict[int, str] = {2: "<i2", 4: "<f4"}
METRES = {"M": 1.0, "METRES": 1.0, "METERS": 1.0, "FT": 0.3048, "FEET": 0.3048}
LONGEST_NS = 1e6


def read_dt1(path: Path, options: ImportOptions) -> xr.Dataset:
    """Read a line; TIMEZERO AT POINT is counted from 0, so it may be off by a sample.

    Raises:
        AnalysisError: A file is missing, or no spacing is known.
        UnreadableFileError: A header is wrong, or the file was cut off.
    """
    data = require_beside(path, ".dt1")
    header_path = require_beside(path, ".hd")
    header = Numbers(header_path.name, text_entries(header_path, "="))
    count = header.count("NUMBER OF TRACES", 1, 1 << 24)
    samples = header.count("NUMBER OF PTS/TRC", 2, 1 << 16)
    window_s = 1e-9 * header.number("TOTAL TIME WINDOW", 1e-3, LONGEST_NS)
    unit = str(header.values.get("POSITION UNITS", "")).upper()
    if unit not in METRES:
        raise header.refused("POSITION UNITS", Message("m or ft"))
    content = content_of(data, 2)
    size = len(content) // count
    bytes_per_sample = (size - HEADER_BYTES) // samples
    if bytes_per_sample not in TYPES or HEADER_BYTES + bytes_per_sample * samples != size:
        size = HEADER_BYTES + 2 * samples
    if trace_count(data, len(content), size) != count:
        raise _contradiction(data, Message("it has not {count} traces", count=count))
    traces = np.frombuffer(
        content,
        [("header", "<f4", HEADER_FLOATS), ("samples", TYPES[bytes_per_sample], samples)],
    )
    headers = traces["header"].astype(np.float64)
    if not np.all(headers[:, SAMPLES] == samples):
        raise _contradiction(data, Message("its traces have not {count} samples", count=samples))
    # Old files have 0 here.
    if not np.isin(headers[:, SAMPLE_BYTES], (0.0, bytes_per_sample)).all():
        raise _contradiction(data, Message("its samples have not {n} bytes", n=bytes_per_sample))
    step_s = window_s / samples
    separation_m = METRES[unit] * header.number("ANTENNA SEPARATION", 0.0, 1e3, 0.0)
    return as_survey(
        Traces(
            data,
            traces["samples"].astype(np.float64),
            step_s=step_s,
            zero_s=step_s * header.number("TIMEZERO AT POINT", 0.0, samples, 0.0),
            x_m=headers[:, POSITION] * METRES[unit],
            separation_m=separation_m or None,
        ),
        options,
    )


def _contradiction(path: Path, reason: Message) -> UnreadableFileError:
    return UnreadableFileError(
        Message(
            "{file} contradicts its HD file: {reason}; one of them was cut off, damaged, or is of "
            "another line",
            file=path.name,
            reason=reason,
        )
    )


def _imported(path: Path, options: ImportOptions, _: Progress) -> xr.Dataset:
    return read_dt1(path, options)


def _whole(path: Path) -> Optional[Path]:
    return path if path.suffix.lower() in (".dt1", ".hd") and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, TRACES)
