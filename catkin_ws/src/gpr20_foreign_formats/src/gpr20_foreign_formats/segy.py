"""SEG-Y of revision 0 to 2: real A-scans of other programs.

A header counts microseconds, but radar needs less, and no standard says what a program counts
instead: picoseconds are assumed, with a note.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.common import EVEN
from gpr20_analysis.formats.imports import ImportOptions
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header, content_of, other_kind, refusal
from gpr20_foreign_formats.traces import Traces, format_of, needs_spacing

TEXT_BYTES, START_BYTES, HEADER_BYTES = 3200, 3600, 240
IBM_FLOAT = 1
TYPES: Dict[int, str] = {
    **{IBM_FLOAT: "?u4", 2: "?i4", 3: "?i2", 5: "?f4", 6: "?f8", 8: "i1", 9: "?i8"},
    **{10: "?u4", 11: "?u2", 12: "?u8", 16: "u1"},
}
"""Codes of the kinds of samples; IBM floats are read as they are stored."""
# Places in the file and in the header of a trace, by the standard's bytes, which count from 1, and
# types; ? stands for the order of the bytes.
BINARY: Dict[str, Tuple[int, str]] = {
    "sample interval": (3217, "?u2"),
    "number of samples": (3221, "?u2"),
    "format code": (3225, "?u2"),
    "measurement system": (3255, "?u2"),
    "revision": (3501, ">u2"),
    "extended headers": (3505, "?i2"),
}
OF_REVISION_2: Dict[str, Tuple[int, str]] = {
    "extended samples": (3269, "?u4"),
    "extended interval": (3273, "?f8"),
    "additional trace headers": (3507, "?u2"),  # from 2.1 on; before it is four bytes long
    "offset of the first trace": (3521, "?u8"),
    "data trailers": (3529, "?i4"),
}
OF_TRACE: Dict[str, Tuple[int, str]] = {
    "code": (29, "?i2"),
    "offset": (37, "?i4"),
    "scalar": (71, "?i2"),
    "source": (73, "2?i4"),
    "group": (81, "2?i4"),
    "units": (89, "?i2"),
    "delay": (109, "?i2"),
    "count": (115, "?u2"),
    "interval": (117, "?u2"),
    "cdp": (181, "2?i4"),
}
DEAD, NO_GROUND = (2, 3), range(4, 10)
"""Codes of traces that are dead or dummies, and of those of a sweep or of time."""
LENGTHS, FEET, M_PER_FT = (0, 1), 2, 0.3048
PS_PER_S = 1e12
FIRST_REVISION, SECOND_REVISION, MOST_EXTENDED = (1, 0x0100, 0x0101), (0x0200, 0x0201), 1000


def read_segy(path: Path, options: ImportOptions) -> Traces:
    """Read a file whose traces all have the same length.

    Places are halfway between source and receiver group, or those of the CDP if these are 0.

    Raises:
        AnalysisError: The places are no lengths, or no line of constant separation.
        UnreadableFileError: The file is damaged, has another kind of samples, or was changed; or
            its times are not clear.
    """
    content = content_of(path)
    header, order = _binary_header(path, content)
    notes: List[Message] = []
    traces = _traces(path, content, header, order, notes)
    interval = float(header.entries["sample interval"] or traces["interval"][0])
    # Only a fraction, which revision 2 allows, can count what the standard says.
    unit_s, unit = (1e-6, "us") if 0.0 < interval < 1.0 else (1.0 / PS_PER_S, "ps")
    _check_traces(path, traces, interval, options)
    found = Traces(path, _samples(traces, header), interval * unit_s, notes=notes)
    found.values[np.isin(traces["code"], DEAD)] = np.nan
    if options.interval_s is not None:
        found.step_s = options.interval_s
    else:
        assumed = Message(
            "{file} does not say what its sample interval of {interval:g} counts; {unit} is "
            "assumed, a record of {duration_ns:g} ns; give --interval PS if that is wrong",
            file=path.name,
            interval=interval,
            unit=unit,
            duration_ns=1e9 * found.step_s * found.values.shape[1],
        )
        notes.append(assumed)
    if options.spacing_m is None:
        _add_places(found, traces, header, options)
    return found


def _binary_header(path: Path, content: bytes) -> Tuple[Header, str]:
    """Return the binary header, and the order of the bytes in which its code is one."""
    if len(content) < START_BYTES:
        raise other_kind(path.name, "SEG-Y")

    def read(fields: Dict[str, Tuple[int, str]], order: str) -> Dict[str, Any]:
        return {
            key: np.frombuffer(content, kind.replace("?", order), 1, place - 1)[0].item()
            for key, (place, kind) in fields.items()
        }

    for order in "><":
        found = read(BINARY, order)
        if found["format code"] not in TYPES:
            continue
        # Older files may have anything in these places.
        is_second = found["revision"] in SECOND_REVISION
        later = read(OF_REVISION_2, order) if is_second else dict.fromkeys(OF_REVISION_2, 0)
        if found["revision"] == SECOND_REVISION[0]:
            later.update(read({"additional trace headers": (3507, "?u4")}, order))
        if found["revision"] not in (*FIRST_REVISION, *SECOND_REVISION):
            found["extended headers"] = 0
        found["sample interval"] = later["extended interval"] or found["sample interval"]
        found["number of samples"] = later["extended samples"] or found["number of samples"]
        return Header(path.name, {**found, **later}), order
    raise other_kind(path.name, "SEG-Y", f"format code {found['format code']}")


def _traces(
    path: Path, content: bytes, header: Header, order: str, notes: List[Message]
) -> np.ndarray:
    """Return the headers and samples of the traces, as they are stored.

    Where the header and the traces count their samples differently, the file's size decides.
    """
    kind = np.dtype(TYPES[header.entries["format code"]].replace("?", order))
    headers = HEADER_BYTES * (1 + header.count("additional trace headers", 0, MOST_EXTENDED))
    extended = header.count("extended headers", 0, MOST_EXTENDED)
    offset = int(header.entries["offset of the first trace"]) or START_BYTES + TEXT_BYTES * extended
    trailers = header.count("data trailers", 0, MOST_EXTENDED)
    size = len(content) - TEXT_BYTES * trailers - offset
    said = header.number("number of samples", 0, 1 << 24)
    at = offset + OF_TRACE["count"][0] - 1
    in_trace = int.from_bytes(content[at : at + 2], "big" if order == ">" else "little")
    counts = [int(one) for one in dict.fromkeys((said, in_trace)) if one > 1]
    fitting = [one for one in counts if size > 0 and size % (headers + one * kind.itemsize) == 0]
    if not fitting:
        raise UnreadableFileError(
            Message(
                "{file} has {size} bytes of traces, which are no whole traces of {counts} samples, "
                "as its headers say: it was cut off, or a header is damaged",
                file=path.name,
                size=size,
                counts=" / ".join(map(str, counts)) or "0",
            )
        )
    fields = [*OF_TRACE.items(), ("samples", (headers + 1, f"{fitting[0]}{kind.str}"))]
    layout = np.dtype(
        {
            "names": [name for name, _ in fields],
            "formats": [one.replace("?", order) for _, (_, one) in fields],
            "offsets": [at - 1 for _, (at, _) in fields],
            "itemsize": headers + fitting[0] * kind.itemsize,
        }
    )
    traces = np.frombuffer(content, layout, size // layout.itemsize, offset)
    own_counts = np.unique(traces["count"][traces["count"] != 0])
    if len(own_counts) > 1:
        in_traces = Header(path.name, {"number of samples": f"{own_counts[0]}, {own_counts[1]}"})
        raise in_traces.refused("number of samples", Message("the same in all traces"))
    notes += [
        Message(
            "headers of {file} say {other} and {count} samples; by the file's size its traces have "
            "{count}",
            file=path.name,
            other=other,
            count=fitting[0],
        )
        for other in counts
        if other != fitting[0]
    ]
    return traces


def _check_traces(path: Path, traces: np.ndarray, interval: float, options: ImportOptions) -> None:
    intervals, delays, codes = (traces[one] for one in ("interval", "delay", "code"))
    ground = Message("1, of a trace that shows the ground")
    checks = [("trace identification code", codes[np.isin(codes, NO_GROUND)], ground)]
    if options.interval_s is None:
        same = Message("{interval:g} in all headers, or give --interval PS", interval=interval)
        others = intervals[~np.isin(intervals, (0, int(interval)))]
        checks.append(("sample interval", others, same))
    if options.time_zero_s is None:
        start = Message("0, or give --time-zero NS, counted from the first sample")
        checks.append(("delay recording time", delays[delays != 0], start))
    for name, wrong, allowed in checks:
        if wrong.size:
            raise Header(path.name, {name: int(wrong[0])}).refused(name, allowed)


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


def _add_places(found: Traces, traces: np.ndarray, header: Header, options: ImportOptions) -> None:
    if not np.isin(traces["units"], LENGTHS).all():
        raise needs_spacing(found.path, Message("the places of the traces are angles"))
    unit_m = M_PER_FT if header.entries["measurement system"] == FEET else 1.0
    source, group, cdp = (
        unit_m * _scaled(traces[one].T.astype(np.float64), traces["scalar"])
        for one in ("source", "group", "cdp")
    )
    is_placed = source.any() and group.any()
    apart_m = np.hypot(*(source - group)) if is_placed else np.abs(unit_m * traces["offset"])
    if options.separation_m is None and np.ptp(apart_m) > EVEN * apart_m.mean():
        raise refusal(
            Message(
                "{file}: source and receiver are {least_m:g} to {most_m:g} m apart, so it is no "
                "line of constant separation, which images need; give --separation if that is "
                "wrong",
                file=found.path.name,
                least_m=apart_m.min(),
                most_m=apart_m.max(),
            )
        )
    if not is_placed:
        found.x_m, found.y_m = cdp if cdp.any() else source + group
        return
    found.x_m, found.y_m = (source + group) / 2.0
    found.separation_m = float(apart_m.mean()) or None


IMPORT = format_of(read_segy, ".sgy", ".segy", takes="interval_s")
