"""The files of MALA's radars: samples in RD3 (16 bit) or RD7 (32 bit), text header RAD beside."""

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

BYTES: Dict[str, int] = {".rd3": 2, ".rd7": 4}
SAME_WINDOW = 0.02
"""How much TIMEWINDOW may differ from SAMPLES / FREQUENCY, as a share."""
HZ_PER_MHZ = 1e6


def read_rd3(path: Path, options: ImportOptions) -> xr.Dataset:
    """Read a line of one channel.

    SIGNAL POSITION is in units of the instrument, so time zero is not known.

    Raises:
        AnalysisError: A file is missing, or no spacing is known.
        UnreadableFileError: The header is wrong, or the file was cut off.
    """
    data = require_beside(path, *([path.suffix.lower()] if path.suffix.lower() in BYTES else BYTES))
    header_path = require_beside(path, ".rad")
    header = Numbers(header_path.name, text_entries(header_path, ":"))
    samples = header.count("SAMPLES", 2, 1 << 16)
    frequency_hz = HZ_PER_MHZ * header.number("FREQUENCY", 1.0, 1e7)
    window_s = 1e-9 * header.number("TIMEWINDOW", 1e-3, 1e6, 1e9 * samples / frequency_hz)
    if abs(window_s * frequency_hz / samples - 1.0) > SAME_WINDOW:
        raise header.refused(
            "TIMEWINDOW",
            Message(
                "SAMPLES / FREQUENCY, {window_ns:g} ns", window_ns=1e9 * samples / frequency_hz
            ),
        )
    width = BYTES[data.suffix.lower()]
    content = content_of(data, width)
    count = trace_count(data, len(content), samples * width)
    last = header.count("LAST TRACE", 1, 1 << 24)
    if count != last:
        raise UnreadableFileError(
            Message(
                "{file} has {count} traces, but LAST TRACE in {header} is {last}: the file was cut "
                "off, or is of another line; if it is whole, correct LAST TRACE",
                file=data.name,
                count=count,
                header=header_path.name,
                last=last,
            )
        )
    values = np.frombuffer(content, f"<i{width}").reshape(count, samples)
    by_time = header.values.get("TIME FLAG") == "1" and header.values.get("DISTANCE FLAG") != "1"
    spacing_m = 0.0 if by_time else header.number("DISTANCE INTERVAL", 0.0, 1e3, 0.0)
    separation_m = header.number("ANTENNA SEPARATION", 0.0, 1e3, 0.0)
    return as_survey(
        Traces(
            data,
            values / 2.0 ** (8 * width - 1),
            step_s=1.0 / frequency_hz,
            x_m=np.arange(count) * spacing_m if spacing_m else None,
            separation_m=separation_m or None,
        ),
        options,
    )


def _imported(path: Path, options: ImportOptions, _: Progress) -> xr.Dataset:
    return read_rd3(path, options)


def _whole(path: Path) -> Optional[Path]:
    return path if path.suffix.lower() in (*BYTES, ".rad") and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, TRACES)
