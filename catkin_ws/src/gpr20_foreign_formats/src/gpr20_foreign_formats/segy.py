"""SEG-Y of revision 0 and 1: real A-scans, as `gpr20 export` and other programs write them.

A header counts microseconds, but radar needs less, and no standard says what a program counts
instead. Own files say that they mean picoseconds; of others it is assumed, with a note.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any, List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults, lazy
from gpr20_analysis.errors import (
    AnalysisError,
    MissingLibraryError,
    UnreadableFileError,
    library_missing,
)
from gpr20_analysis.formats.format import ImportFormat, ImportOptions
from gpr20_analysis.formats.provenance import SIMULATED
from gpr20_analysis.formats.segy import (
    DEAD,
    LENGTH_UNITS,
    MEASURED,
    MOVED,
    PS_PER_S,
    UNIT_OF_TIME,
)
from gpr20_analysis.formats.sums_beside import checked_facts
from gpr20_analysis.processing.display import DISPLAY_ONLY
from gpr20_analysis.processing.to_frequency import EVEN
from gpr20_analysis.progress import Progress
from gpr20_analysis.sentences import with_sentence
from gpr20_common.message import Message
from gpr20_foreign_formats.header_numbers import BYTES_PER_SAMPLE
from gpr20_foreign_formats.traces import TRACES, Traces, as_survey, needs_spacing
from gpr20_survey.files.regular_file import check_regular

TEXT_BYTES, FORMAT_AT = 3200, 3224
EBCDIC_C = b"\xc3"
FORMATS = {1, 2, 3, 5, 8}  # IBM float, 32 and 16 bit, IEEE float, 8 bit
FEET, M_PER_FT = 2, 0.3048
ROTATION, COMBINED = re.compile(r"ANTENNAS AT (-?[\d.]+) DEG"), "ANTENNAS AT NAN DEG"
FIRST = re.compile(r"THE FIRST AT (-?\d+) PS")
MOVED_NOTE = Message(
    "the traces were shifted to their time zero before the export, so depths would be wrong"
)


def read_segy(path: Path, options: ImportOptions) -> xr.Dataset:
    """Read a file whose traces all have the same length.

    Places are halfway between source and receiver group, or those of the CDP if these are 0.

    Raises:
        MissingLibraryError: segyio is not installed.
        AnalysisError: Places are neither recorded as lengths nor given by the spacing.
        UnreadableFileError: The file is damaged, has another kind of samples, or was changed.
    """
    segyio = _segyio()
    check_regular(path, follow_link=True)
    purpose = Message("reading {file}", file=path.name)
    lazy.require_bytes(BYTES_PER_SAMPLE * path.stat().st_size, purpose)
    text, order = _start(path)
    try:
        with segyio.open(str(path), ignore_geometry=True, endian=order) as file:
            found = _traces(segyio, file, path, text, options)
    except AnalysisError:
        raise
    # On damaged files segyio and numpy raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message(
                "{file} is damaged, or its traces are not all of one length", file=path.name,
                details=error,
            )
        ) from error  # fmt: skip
    data = as_survey(found, options)
    if UNIT_OF_TIME in text and COMBINED in text:
        data[dataset.POLARIZATION] = [np.nan]
    if MOVED in text:
        data = data.assign_attrs(with_sentence(data.attrs, DISPLAY_ONLY, MOVED_NOTE))
    return data


def _segyio() -> Any:
    try:
        import segyio
    except ImportError as error:
        raise MissingLibraryError(library_missing("segyio", "segy")) from error
    return segyio


def _start(path: Path) -> Tuple[str, str]:
    """Return the textual header, and the order of the bytes."""
    with path.open("rb") as stream:
        start = stream.read(FORMAT_AT + 2)
    if len(start) < FORMAT_AT + 2:
        raise UnreadableFileError(
            Message("{file} is shorter than the headers of a SEG-Y file", file=path.name)
        )
    coding = "cp500" if start[:1] == EBCDIC_C else "latin-1"
    for order, mark in (("big", ">"), ("little", "<")):
        if struct.unpack(f"{mark}H", start[FORMAT_AT:])[0] in FORMATS:
            return start[:TEXT_BYTES].decode(coding), order
    raise UnreadableFileError(
        Message(
            "{file} has no samples of IBM or IEEE floats or integers (code {codes}), or is no "
            "SEG-Y file",
            file=path.name,
            codes=", ".join(map(str, sorted(FORMATS))),
        ),
        fault=faults.FILE_CONTENT,
    )


def _traces(segyio: Any, file: Any, path: Path, text: str, options: ImportOptions) -> Traces:
    field, own = segyio.TraceField, UNIT_OF_TIME in text
    values = np.asarray(file.trace.raw[:], np.float64)
    values[file.attributes(field.TraceIdentificationCode)[:] == DEAD] = np.nan
    notes: List[Message] = []
    interval = int(file.bin[segyio.BinField.Interval]) or int(
        file.attributes(field.TRACE_SAMPLE_INTERVAL)[0][0]
    )
    step_s = interval / PS_PER_S if options.interval_s is None else options.interval_s
    if not own and options.interval_s is None:
        notes = [
            Message(
                "{file} does not say what its sample interval of {interval} counts; picoseconds "
                "are assumed, a record of {duration_ns:g} ns; give --interval PS if that is wrong",
                file=path.name,
                interval=interval,
                duration_ns=1e9 * step_s * values.shape[1],
            )
        ]
    rotation, first = ROTATION.search(text), FIRST.search(text)
    found = Traces(path, values, step_s, facts=checked_facts(path), notes=notes)
    if options.spacing_m is None:
        _add_places(segyio, file, found)
    if own:
        height_m = _scaled(file, field.ReceiverGroupElevation, field.ElevationScalar)
        found.height_m = np.where(height_m == 0.0, np.nan, height_m)
        found.start_s = int(first.group(1)) / PS_PER_S if first else 0.0
        found.rotation_deg = float(rotation.group(1)) if rotation else 0.0
        found.simulated = False if MEASURED in text else None
    if SIMULATED in text:
        found.simulated = True
    return found


def _scaled(file: Any, key: Any, scalar_key: Any) -> np.ndarray:
    """Return a length of each trace: a positive scalar multiplies, a negative one divides."""
    scalar = file.attributes(scalar_key)[:].astype(np.float64)
    scalar[scalar == 0.0] = 1.0
    values: np.ndarray = file.attributes(key)[:] * np.where(scalar > 0.0, scalar, -1.0 / scalar)
    return values


def _add_places(segyio: Any, file: Any, found: Traces) -> None:
    field, scalar = segyio.TraceField, segyio.TraceField.SourceGroupScalar
    if not np.isin(file.attributes(field.CoordinateUnits)[:], (0, LENGTH_UNITS)).all():
        raise needs_spacing(found.path, Message("the places of the traces are angles"))
    is_feet = file.bin[segyio.BinField.MeasurementSystem] == FEET
    names = (("SourceX", "SourceY"), ("GroupX", "GroupY"), ("CDP_X", "CDP_Y"))
    source, group, cdp = (
        np.stack([_scaled(file, getattr(field, one), scalar) for one in pair])
        * (M_PER_FT if is_feet else 1.0)
        for pair in names
    )
    found.x_m, found.y_m = (source + group) / 2.0
    if not source.any() or not group.any():
        found.x_m, found.y_m = cdp if cdp.any() else source + group
        return
    apart_m = np.hypot(*(source - group))
    if apart_m.all() and np.ptp(apart_m) < EVEN * apart_m.mean():
        found.separation_m = float(apart_m.mean())


def _imported(path: Path, options: ImportOptions, _: Progress) -> xr.Dataset:
    return read_segy(path, options)


def _whole(path: Path) -> Optional[Path]:
    return path if path.suffix.lower() in (".sgy", ".segy") and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, (*TRACES, "interval_s"))
