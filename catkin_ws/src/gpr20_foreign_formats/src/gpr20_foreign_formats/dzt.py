"""The DZT files of GSSI's impulse radars: a line of real A-scans, channels interleaved.

The header is as in the SIR manuals' "DZT file format": little endian, 1024 bytes for each channel.
Samples are counts about the middle of their range.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Dict, List, Optional

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.format import ImportFormat, ImportOptions
from gpr20_analysis.progress import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.header_numbers import Numbers, beside, content_of, trace_count
from gpr20_foreign_formats.traces import TRACES, Traces, as_survey

HEADER_BYTES = 1024
START = struct.Struct("<HHHHh5f")
START_NAMES = ("rh_tag", "rh_data", "rh_nsamp", "rh_bits", "rh_zero", "rhf_sps", "rhf_spm")
START_NAMES += ("rhf_mpm", "rhf_position", "rhf_range")
CHANNELS = struct.Struct("<Hf")
CHANNELS_AT, ANTENNA = 52, slice(98, 112)
TYPES: Dict[int, str] = {8: "u1", 16: "<u2", 32: "<i4"}
MARKS = 2
"""Samples at the start of each trace that hold marks instead of the field."""
MOST_CHANNELS = 16
LONGEST_NS, MOST_PER_M = 1e5, 1e5
HIGHEST_PERMITTIVITY = 1e3


def read_dzt(path: Path, options: ImportOptions) -> xr.Dataset:
    """Read one channel of a file.

    Time zero is the negative of rhf_position, which is the time of the first sample; the spacing
    is 1 / rhf_spm, which is 0 if the traces were taken by time.

    Raises:
        AnalysisError: There are several channels and none was chosen, or no spacing is known.
        UnreadableFileError: The header is wrong, or the file was cut off.
    """
    content = content_of(path, 1)
    header = _header(path, content)
    bits, samples = int(header.values["rh_bits"]), header.count("rh_nsamp", 3, 1 << 16)
    channels = header.count("rh_nchan", 1, MOST_CHANNELS)
    channel = _channel(path, channels, options.channel)
    offset = HEADER_BYTES * header.count("rh_data", 1, (1 << 16) - 1)
    if offset >= HEADER_BYTES * HEADER_BYTES:  # larger values have another meaning
        offset = HEADER_BYTES * channels
    count = trace_count(path, len(content) - offset, channels * samples * bits // 8)
    stored = np.frombuffer(content, TYPES[bits], count * channels * samples, offset)
    values = stored.reshape(count, channels, samples)[:, channel - 1].astype(np.float64)
    # 32-bit samples are signed.
    values = values / 2.0 ** (bits - 1) - (0.0 if bits == 32 else 1.0)
    values[:, :MARKS] = values[:, MARKS : MARKS + 1]
    position_s = 1e-9 * header.number("rhf_position", -LONGEST_NS, LONGEST_NS)
    per_m = header.number("rhf_spm", 0.0, MOST_PER_M)
    return as_survey(
        Traces(
            path,
            values,
            step_s=1e-9 * header.number("rhf_range", 1e-3, LONGEST_NS) / samples,
            start_s=max(position_s, 0.0),
            zero_s=max(-position_s, 0.0) if position_s else None,
            x_m=np.arange(count) / per_m if per_m else None,
            notes=_notes(path, content, header, channel),
        ),
        options,
    )


def _header(path: Path, content: bytes) -> Numbers:
    if len(content) < HEADER_BYTES:
        raise UnreadableFileError(
            Message("{file} is shorter than the header of a DZT file", file=path.name)
        )
    values = dict(zip(START_NAMES, START.unpack_from(content)))
    values.update(zip(("rh_nchan", "rhf_epsr"), CHANNELS.unpack_from(content, CHANNELS_AT)))
    header = Numbers(path.name, values)
    if values["rh_tag"] & 0xFF != 0xFF:
        raise header.refused("rh_tag", Message("a number that ends with the byte 255"))
    if values["rh_bits"] not in TYPES:
        raise header.refused("rh_bits", Message("8, 16 or 32"))
    if values["rhf_epsr"] != 0.0:  # which means that nobody set it
        header.number("rhf_epsr", 1.0, HIGHEST_PERMITTIVITY)
    return header


def _channel(path: Path, channels: int, chosen: Optional[int]) -> int:
    if channels == 1 and chosen is None:
        return 1
    if chosen is None or not 1 <= chosen <= channels:
        raise AnalysisError(
            Message(
                "{file} has {channels} channels; choose one with --channel 1 to {channels}",
                file=path.name,
                channels=channels,
            ),
            fault=faults.OPTION,
        )
    return chosen


def _notes(path: Path, content: bytes, header: Numbers, channel: int) -> List[Message]:
    own = content[HEADER_BYTES * (channel - 1) :][:HEADER_BYTES]
    antenna = own[ANTENNA].split(b"\0")[0].decode("latin-1").strip()
    notes = [
        Message(
            "GSSI antenna {antenna}, permittivity {permittivity:g} in the header, which is not "
            "used; the first {marks} samples of each trace hold marks and are replaced by the next",
            antenna=antenna or "-",
            permittivity=header.values["rhf_epsr"],
            marks=MARKS,
        )
    ]
    others = [beside(path, ending) for ending in (".dzx", ".dzg")]
    notes += [
        Message("{file} is not read: positions and marks in it are not used", file=one.name)
        for one in others
        if one is not None
    ]
    return notes


def _imported(path: Path, options: ImportOptions, _: Progress) -> xr.Dataset:
    return read_dzt(path, options)


def _whole(path: Path) -> Optional[Path]:
    return path if path.suffix.lower() == ".dzt" and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, (*TRACES, "channel"))
