"""SEG-Y of revision 0 and 1: real A-scans, as `gpr20 export` and other programs write them.

A header counts microseconds, but radar needs less, and no standard says what a program counts
instead. Own files say that they mean picoseconds; of others it is assumed, with a note.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Dict, Tuple

import numpy as np

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats import segy
from gpr20_analysis.formats.format import ImportOptions
from gpr20_analysis.formats.provenance import SIMULATED
from gpr20_analysis.formats.sums_beside import checked_facts
from gpr20_analysis.processing.to_frequency import EVEN
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header, content_of, trace_count
from gpr20_foreign_formats.traces import Traces, format_of, needs_spacing

TEXT_BYTES, START_BYTES, HEADER_BYTES = 3200, 3600, 240
EBCDIC_C = b"\xc3"
IBM_FLOAT = 1
TYPES: Dict[int, str] = {IBM_FLOAT: "?u4", 2: "?i4", 3: "?i2", 5: "?f4", 8: "i1"}
"""Codes of the kinds of samples; IBM floats are read as they are stored."""
# Places in the file and in the header of a trace, by the standard's bytes, which count from 1, and
# types; ? stands for the order of the bytes.
BINARY: Dict[str, Tuple[int, str]] = {
    "sample interval": (3217, "?u2"),
    "number of samples": (3221, "?u2"),
    "format code": (3225, "?u2"),
    "measurement system": (3255, "?u2"),
    "revision": (3501, "?u2"),
    "extended headers": (3505, "?i2"),
}
OF_TRACE: Dict[str, Tuple[int, str]] = {
    "code": (29, "?i2"),
    "elevation": (41, "?i4"),
    "elevation_scalar": (69, "?i2"),
    "scalar": (71, "?i2"),
    "source": (73, "2?i4"),
    "group": (81, "2?i4"),
    "units": (89, "?i2"),
    "delay": (109, "?i2"),
    "count": (115, "?u2"),
    "interval": (117, "?u2"),
    "cdp": (181, "2?i4"),
}
FEET, M_PER_FT = 2, 0.3048
FIRST_REVISION, MOST_EXTENDED = (1, 0x0100, 0x0101), 1000
ROTATION = re.compile(r"ANTENNAS AT (-?\d+(?:\.\d+)?) DEG")
FIRST = re.compile(r"THE FIRST AT (-?\d+) PS")


def read_segy(path: Path, options: ImportOptions) -> Traces:
    """Read a file whose traces all have the same length.

    Places are halfway between source and receiver group, or those of the CDP if these are 0.

    Raises:
        AnalysisError: The places are no lengths.
        UnreadableFileError: The file is damaged, has another kind of samples, or was changed; or
            its times are not clear.
    """
    facts, content = checked_facts(path), content_of(path)
    if len(content) < START_BYTES:
        raise UnreadableFileError(
            Message("{file} is shorter than its header must be", file=path.name)
        )
    text = content[:TEXT_BYTES].decode("cp500" if content[:1] == EBCDIC_C else "latin-1").upper()
    header, order = _binary_header(path, content)
    traces = _traces(path, content, header, order)
    is_own = segy.UNIT_OF_TIME in text
    interval = header.entries["sample interval"] or int(traces["interval"][0])
    _check_times(path, traces, interval, options)
    found = Traces(path, _samples(traces, header), interval / segy.PS_PER_S)
    found.values[traces["code"] == segy.DEAD] = np.nan
    found.facts, found.was_moved = facts, segy.MOVED in text
    if options.interval_s is not None:
        found.step_s = options.interval_s
    elif not is_own:
        assumed = Message(
            "{file} does not say what its sample interval of {interval} counts; picoseconds are "
            "assumed, a record of {duration_ns:g} ns; give --interval PS if that is wrong",
            file=path.name,
            interval=interval,
            duration_ns=1e9 * found.step_s * found.values.shape[1],
        )
        found.notes.append(assumed)
    if options.spacing_m is None:
        _add_places(found, traces, header)
    if is_own:
        rotation, first = ROTATION.search(text), FIRST.search(text)
        height_m = _scaled(traces["elevation"], traces["elevation_scalar"])
        found.height_m = np.where(height_m == 0.0, np.nan, height_m)
        found.start_s = int(first.group(1)) / segy.PS_PER_S if first else 0.0
        found.rotation_deg = float(rotation.group(1)) if rotation else 0.0
        found.simulated = False if segy.MEASURED in text else None
    found.simulated = True if SIMULATED in text else found.simulated
    return found


def _binary_header(path: Path, content: bytes) -> Tuple[Header, str]:
    """Return the binary header, and the order of the bytes in which its code is one."""
    for order in "<>":
        values = {
            key: int(np.frombuffer(content, kind.replace("?", order), 1, place - 1)[0])
            for key, (place, kind) in BINARY.items()
        }
        header = Header(path.name, values)
        if values["format code"] in TYPES:
            return header, order
    raise header.refused("format code", Message("one of {codes}", codes=", ".join(map(str, TYPES))))


def _traces(path: Path, content: bytes, header: Header, order: str) -> np.ndarray:
    """Return the headers and samples of the traces, as they are stored."""
    kind = TYPES[header.entries["format code"]].replace("?", order)
    samples = header.count("number of samples", 2, (1 << 16) - 1)
    size = HEADER_BYTES + samples * np.dtype(kind).itemsize
    fields = [*OF_TRACE.items(), ("samples", (HEADER_BYTES + 1, f"{samples}{kind}"))]
    layout = np.dtype(
        {
            "names": [name for name, _ in fields],
            "formats": [one.replace("?", order) for _, (_, one) in fields],
            "offsets": [place - 1 for _, (place, _) in fields],
            "itemsize": size,
        }
    )
    # Older files may have anything in these places.
    is_first = header.entries["revision"] in FIRST_REVISION
    extended = header.count("extended headers", 0, MOST_EXTENDED) if is_first else 0
    offset = START_BYTES + TEXT_BYTES * extended
    traces = np.frombuffer(content, layout, trace_count(path, len(content) - offset, size), offset)
    other = traces["count"][~np.isin(traces["count"], (0, samples))]
    if other.size:
        as_in = Message("{count:g}, as in {file}", count=float(other[0]), file=path.name)
        raise header.refused("number of samples", as_in)
    return traces


def _check_times(path: Path, traces: np.ndarray, interval: int, options: ImportOptions) -> None:
    all_same = Message("{interval} in all headers, or give --interval PS", interval=interval)
    start = Message("0, or give --time-zero NS, counted from the first sample")
    for name, key, given, right, allowed in (
        ("sample interval", "interval", options.interval_s, interval, all_same),
        ("delay recording time", "delay", options.time_zero_s, 0, start),
    ):
        other = traces[key][~np.isin(traces[key], (0, right))]
        if given is None and other.size:
            raise Header(path.name, {name: int(other[0])}).refused(name, allowed)


def _samples(traces: np.ndarray, header: Header) -> np.ndarray:
    stored = traces["samples"]
    if header.entries["format code"] != IBM_FLOAT:
        return stored.astype(np.float64)
    # Sign, exponent of 16 and fraction; also right where the first digit of the fraction is 0.
    power = ((stored >> 24) & 0x7F).astype(np.int32) - 64
    fraction = np.ldexp((stored & 0xFFFFFF).astype(np.float64), 4 * power - 24)
    return np.where(stored >> 31, -fraction, fraction)


def _scaled(values: np.ndarray, scalar: np.ndarray) -> np.ndarray:
    """Return lengths: a positive scalar multiplies, a negative one divides, 0 does nothing."""
    factor = np.where(scalar == 0, 1.0, scalar.astype(np.float64))
    scaled: np.ndarray = values * np.where(factor > 0.0, factor, -1.0 / factor)
    return scaled


def _add_places(found: Traces, traces: np.ndarray, header: Header) -> None:
    if not np.isin(traces["units"], (0, segy.LENGTH_UNITS)).all():
        raise needs_spacing(found.path, Message("the places of the traces are angles"))
    unit_m = M_PER_FT if header.entries["measurement system"] == FEET else 1.0
    source, group, cdp = (
        unit_m * _scaled(traces[one].T.astype(np.float64), traces["scalar"])
        for one in ("source", "group", "cdp")
    )
    if not source.any() or not group.any():
        found.x_m, found.y_m = cdp if cdp.any() else source + group
        return
    found.x_m, found.y_m = (source + group) / 2.0
    apart_m = np.hypot(*(source - group))
    if apart_m.all() and np.ptp(apart_m) < EVEN * apart_m.mean():
        found.separation_m = float(apart_m.mean())


IMPORT = format_of(read_segy, ".sgy", ".segy", takes="interval_s")
