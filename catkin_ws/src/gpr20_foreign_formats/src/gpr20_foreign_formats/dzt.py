"""The DZT files of GSSI's impulse radars: a line of real A-scans, channels interleaved.

The header is that of the SIR manuals' "DZT file format": little endian, 1024 bytes a channel.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Dict, Tuple

import numpy as np

from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.format import ImportOptions
from gpr20_common.message import Message
from gpr20_foreign_formats.header import Header, content_of, siblings, trace_count
from gpr20_foreign_formats.traces import Traces, format_of

HEADER_BYTES = 1024
FIELDS: Dict[str, Tuple[int, str]] = {
    **{"rh_tag": (0, "<H"), "rh_data": (2, "<H"), "rh_nsamp": (4, "<H"), "rh_bits": (6, "<H")},
    **{"rhf_spm": (14, "<f"), "rhf_position": (22, "<f"), "rhf_range": (26, "<f")},
    **{"rh_nchan": (52, "<H"), "rhf_epsr": (54, "<f")},
}
ANTENNA = slice(98, 112)
TYPES: Dict[int, str] = {8: "u1", 16: "<u2", 32: "<i4"}
MARKS = 2
"""Samples at the start of each trace that hold marks instead of the field."""
MOST_CHANNELS = 16
LONGEST_NS, MOST_PER_M, HIGHEST_PERMITTIVITY = 1e5, 1e5, 1e3


def read_dzt(path: Path, options: ImportOptions) -> Traces:
    """Read one channel of a file, as shares of its full scale.

    Time zero is the negative of rhf_position, the time of the first sample; the spacing is
    1 / rhf_spm, which is 0 if traces were taken by time, negative if the line goes back.

    Raises:
        AnalysisError: There are several channels and none was chosen.
        UnreadableFileError: The header is wrong, or the file was cut off.
    """
    content = content_of(path)
    header = _header(path, content)
    bits, samples = header.entries["rh_bits"], header.count("rh_nsamp", MARKS + 1, (1 << 16) - 1)
    channels = header.count("rh_nchan", 1, MOST_CHANNELS)
    channel = 1 if options.channel is None and channels == 1 else options.channel
    if channel is None or not 1 <= channel <= channels:
        raise AnalysisError(
            Message(
                "{file} has {channels} channels; choose one with --channel 1 to {channels}",
                file=path.name,
                channels=channels,
            )
        )
    blocks = header.count("rh_data", 1, (1 << 16) - 1)
    # Larger values have another meaning.
    offset = HEADER_BYTES * (blocks if blocks < HEADER_BYTES else channels)
    count = trace_count(path, len(content) - offset, channels * samples * bits // 8)
    stored = np.frombuffer(content, TYPES[bits], count * channels * samples, offset)
    own: np.ndarray = stored.reshape(count, channels, samples)[:, channel - 1, :]
    # Only 32-bit samples are signed.
    values = own / 2.0 ** (bits - 1) - (0.0 if bits == 32 else 1.0)
    values[:, :MARKS] = values[:, MARKS : MARKS + 1]
    position_s = 1e-9 * header.number("rhf_position", -LONGEST_NS, LONGEST_NS)
    per_m = header.number("rhf_spm", -MOST_PER_M, MOST_PER_M)
    note = Message(
        "GSSI antenna {antenna}, permittivity {permittivity:g} in the header, which is not used; "
        "the first {marks} samples of each trace hold marks and are replaced by the next",
        antenna=content[HEADER_BYTES * (channel - 1) :][ANTENNA].split(b"\0")[0].decode("latin-1"),
        permittivity=header.entries["rhf_epsr"],
        marks=MARKS,
    )
    ignored = [
        Message("{file} is not read: positions and marks in it are not used", file=one.name)
        for one in siblings(path, ".dzx", ".dzg")
    ]
    return Traces(
        path,
        values,
        step_s=1e-9 * header.number("rhf_range", 1e-3, LONGEST_NS) / samples,
        start_s=max(position_s, 0.0),
        zero_s=max(-position_s, 0.0) if position_s else None,
        x_m=np.arange(count) / per_m if per_m else None,
        notes=[note, *ignored],
    )


def _header(path: Path, content: bytes) -> Header:
    if len(content) < HEADER_BYTES:
        raise UnreadableFileError(
            Message("{file} is shorter than its header must be", file=path.name)
        )
    header = Header(
        path.name,
        {key: struct.unpack_from(kind, content, at)[0] for key, (at, kind) in FIELDS.items()},
    )
    if header.entries["rh_tag"] & 0xFF != 0xFF:
        raise header.refused("rh_tag", Message("255, as in DZT files"))
    if header.entries["rh_bits"] not in TYPES:
        raise header.refused("rh_bits", Message("one of {codes}", codes=", ".join(map(str, TYPES))))
    if header.entries["rhf_epsr"] != 0.0:  # which means that nobody set it
        header.number("rhf_epsr", 1.0, HIGHEST_PERMITTIVITY)
    return header


IMPORT = format_of(read_dzt, ".dzt", takes="channel")
