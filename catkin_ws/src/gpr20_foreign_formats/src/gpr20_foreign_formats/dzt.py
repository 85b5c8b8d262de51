"""The DZT files of GSSI's impulse radars: a line of real A-scans, channels interleaved.

The header is that of the SIR manuals' "DZT file format": little endian, 1024 bytes a channel.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.imports import ImportOptions
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header, content_of, other_kind, trace_count, unread_beside
from gpr20_foreign_formats.traces import Traces, format_of

HEADER_BYTES = 1024
FIELDS: Dict[str, Tuple[int, str]] = {
    **{"rh_tag": (0, "<H"), "rh_data": (2, "<H"), "rh_nsamp": (4, "<H"), "rh_bits": (6, "<H")},
    **{"rhf_spm": (14, "<f"), "rhf_position": (22, "<f"), "rhf_range": (26, "<f")},
    **{"rh_rgain": (40, "<H"), "rh_nchan": (52, "<H"), "rhf_epsr": (54, "<f")},
}
OF_ALL_CHANNELS = ("rh_nsamp", "rh_bits", "rh_nchan", "rhf_spm")
ANTENNA = slice(98, 112)
TYPES: Dict[int, str] = {8: "u1", 16: "<u2", 32: "<i4"}
OTHER_TAG = 0x0700  # of some instruments; all others end in 0xFF
MARKS = 2
"""Samples at the start of each trace that hold marks instead of the field."""
MOST_CHANNELS, MOST_GAINS = 16, 64
LONGEST_NS, MOST_PER_M, HIGHEST_PERMITTIVITY = 1e5, 1e5, 1e3


def read_dzt(path: Path, options: ImportOptions) -> Traces:
    """Read one channel of a file, as shares of its full scale, by the channel's own header.

    Time zero is the negative of rhf_position, the time of the first sample; the spacing is
    1 / rhf_spm, which is 0 if traces were taken by time, negative if the line goes back.

    Raises:
        AnalysisError: There are several channels and none was chosen.
        UnreadableFileError: A header is wrong, or the file was cut off.
    """
    content = content_of(path)
    first = _header(path, content, 0)
    samples = first.count("rh_nsamp", MARKS + 1, (1 << 16) - 1)
    channels = first.count("rh_nchan", 1, MOST_CHANNELS)
    channel = 1 if options.channel is None and channels == 1 else options.channel
    if channel is None or not 1 <= channel <= channels:
        raise AnalysisError(
            Message(
                "{file} has {channels} channels; choose one with --channel 1 to {channels}",
                file=path.name,
                channels=channels,
            )
        )
    blocks = first.count("rh_data", channel, (1 << 16) - 1)
    # Larger values have another meaning.
    blocks = blocks if blocks < HEADER_BYTES else channels
    own = first if channel == 1 else _header(path, content, HEADER_BYTES * (channel - 1))
    for key in OF_ALL_CHANNELS:
        expected = first.entries[key]
        # NaN differs from itself; it is refused below, as no number.
        if own is not first and own.entries[key] != expected:
            as_first = Message("{expected:g}, as of the first channel", expected=expected)
            raise own.refused(key, as_first)
    bits, offset = first.entries["rh_bits"], HEADER_BYTES * blocks
    count = trace_count(path, len(content) - offset, channels * samples * bits // 8)
    stored = np.frombuffer(content, TYPES[bits], count * channels * samples, offset)
    chosen: np.ndarray = stored.reshape(count, channels, samples)[:, channel - 1, :]
    # Only 32-bit samples are signed.
    values = chosen / 2.0 ** (bits - 1) - (0.0 if bits == 32 else 1.0)
    values[:, :MARKS] = values[:, MARKS : MARKS + 1]
    position_s = 1e-9 * own.number("rhf_position", -LONGEST_NS, LONGEST_NS)
    per_m = own.number("rhf_spm", -MOST_PER_M, MOST_PER_M)
    return Traces(
        path,
        values,
        step_s=1e-9 * own.number("rhf_range", 1e-3, LONGEST_NS) / samples,
        start_s=max(position_s, 0.0),
        zero_s=max(-position_s, 0.0) if position_s else None,
        x_m=np.arange(count) / per_m if per_m else None,
        notes=[
            *_notes(own, content[HEADER_BYTES * (channel - 1) : offset]),
            *unread_beside(path, ".dzx", ".dzg", ".dza"),
        ],
    )


def _header(path: Path, content: bytes, start: int) -> Header:
    """Return the header of a channel, which begins at this byte."""
    if len(content) < start + HEADER_BYTES:
        raise other_kind(path.name, "DZT")
    entries: Dict[str, Any] = {
        key: struct.unpack_from(kind, content, start + at)[0] for key, (at, kind) in FIELDS.items()
    }
    header = Header(path.name, entries)
    if entries["rh_tag"] & 0xFF != 0xFF and entries["rh_tag"] != OTHER_TAG:
        raise other_kind(path.name, "DZT", f"rh_tag {entries['rh_tag']:#06x} at byte {start}")
    if entries["rh_bits"] not in TYPES:
        raise other_kind(path.name, "DZT", f"rh_bits {entries['rh_bits']} at byte {start}")
    if entries["rhf_epsr"] != 0.0:  # which means that nobody set it
        header.number("rhf_epsr", 1.0, HIGHEST_PERMITTIVITY)
    return header


def _notes(header: Header, block: bytes) -> List[Message]:
    """Return what the header of a channel, whose bytes come first, says that is not used."""
    antenna = Message(
        "GSSI antenna {antenna}, permittivity {permittivity:g} in the header, which is not used; "
        "the first {marks} samples of each trace hold marks and are replaced by the next",
        antenna=block[ANTENNA].split(b"\0")[0].decode("latin-1"),
        permittivity=header.entries["rhf_epsr"],
        marks=MARKS,
    )
    # A count of points, then gains in dB at even times.
    start = header.entries["rh_rgain"]
    count = int.from_bytes(block[start : start + 2], "little") if start else 0
    gains_db = np.frombuffer(block[start + 2 :][: 4 * min(count, MOST_GAINS)], "<f4")
    if len(gains_db) < 2 or not np.isfinite(gains_db).all() or not np.ptp(gains_db):
        return [antenna]
    gain = Message(
        "the header has a gain over time of {first_db:g} to {last_db:g} dB; if the instrument "
        "applied it, it is still in the samples, so levels of later echoes are too high",
        first_db=gains_db[0],
        last_db=gains_db[-1],
    )
    return [antenna, gain]


IMPORT = format_of(read_dzt, ".dzt", takes="channel")
