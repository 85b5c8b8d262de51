"""The output of gprMax: one simulated A-scan per file, or the file that merges many.

Files are .out or, from version 4, .h5. The merged file of `outputfiles_merge` holds fields (time,
trace) and no source; from version 4 it keeps the places of the traces, before that none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, work
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.formats.imports import Band, ImportFormat, ImportOptions
from gpr20_analysis.read.survey_attributes import ANTENNA_SEPARATION
from gpr20_analysis.sentences import with_notes
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats.gprmax_source import Signal, check_strength, source_of
from gpr20_foreign_formats.header import (
    BYTES_PER_SAMPLE,
    Header,
    hdf5_with,
    no_files,
    opened_hdf5,
    refusal,
)
from gpr20_foreign_formats.traces import needs_spacing

PATTERNS = ("*.out", "*.h5")
ROTATION_DEG = {"Ex": 0.0, "Ey": 90.0, "Ez": 90.0}
SAME_M = 1e-6
RECEIVER, SOURCE, EXCITATION = "rxs/rx1", "srcs/src1", "srcs/src1/excitation"
PLACES = "trace_metadata"
DIVIDED = Message(
    "simulated by gprMax; the spectra are the received field divided by the source signal, so "
    "delays are correct, but amplitudes are in V/m per unit of the source instead of S21"
)
NO_PLACES = Message(
    "the merged file holds no places: positions begin at 0, and are those of the receiver"
)
FLAT = Message(
    "a model of two dimensions: its y is read as height, and the field along z as that across the "
    "line, at 90 degrees"
)


@dataclass(frozen=True)
class _Trace:
    """An A-scan: its file, field, and the places of receiver and source (x, y, z) [m].

    A flat model has one cell along z; its y points upwards.
    """

    file: str
    component: str
    is_flat: bool
    field: Signal
    receiver_m: np.ndarray
    source_m: Optional[np.ndarray]
    source: Optional[Signal]


def read_gprmax(path: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    """Read the A-scans of a folder or of one file and compute their spectra.

    The place of a sample is halfway between source and receiver. Ex is 0 degrees and Ey 90 degrees.
    The component along the source is used, which single files of version 4 name; in others it is
    the strongest.

    Raises:
        AnalysisError: There is no such file, or the source is unknown.
        UnreadableFileError: A file is damaged, its antennas do not move together, or its time step
            or source does not cover the band.
    """
    paths = [path] if path.is_file() else sorted(_files(path))
    if not paths:
        raise no_files(path, ", ".join(PATTERNS))
    given = source_of(options.source) if options.source is not None else None
    band = options.band or Band()
    traces = [one for file in progress(paths, len(paths)) for one in _read(file, options.spacing_m)]
    slowest_s = max(trace.field.step_s for trace in traces)
    if band.stop_hz >= 0.5 / slowest_s:
        raise refusal(
            Message(
                "{file} has a time step of {step_s:g} s, which covers frequencies up to "
                "{highest_hz:g} Hz; give a --band that ends below that, not at {stop_hz:g} Hz",
                file=path.name,
                step_s=slowest_s,
                highest_hz=0.5 / slowest_s,
                stop_hz=band.stop_hz,
            )
        )
    height_m = np.nan if options.height_m is None else options.height_m
    data = on_grid(
        printable(path.name),
        _positions(traces),
        [_spectrum(trace, given, band.frequency_hz) for trace in traces],
        [height_m] * len(traces),
        band.frequency_hz,
        [],
        simulated=True,
    )
    given_m = options.separation_m
    separation_m = _separation_m(path.name, traces) if given_m is None else given_m
    if separation_m is not None:
        data = data.assign_attrs({ANTENNA_SEPARATION: separation_m})
    flat = [FLAT] if traces[0].is_flat else []
    places = [NO_PLACES] if traces[0].source_m is None else []
    return data.assign_attrs(with_notes(data, [DIVIDED, *flat, *places]))


def _files(folder: Path) -> List[Path]:
    return [one for pattern in PATTERNS for one in folder.glob(pattern)]


def _spectrum(trace: _Trace, given: Optional[Signal], frequency_hz: np.ndarray) -> np.ndarray:
    source = given or trace.source
    if source is None:
        raise AnalysisError(
            Message(
                "{file} does not contain the source signal (single files of gprMax 4 do), so the "
                "delays are unknown; give --source, such as ricker:1.5e9",
                file=trace.file,
            )
        )
    field = trace.field.spectrum(frequency_hz)
    return field / check_strength(source, frequency_hz, trace.file)


def _positions(traces: Sequence[_Trace]) -> np.ndarray:
    """Return rotation [deg], y and x [mm] of each trace."""
    others_m = [one.receiver_m if one.source_m is None else one.source_m for one in traces]
    places_m = (np.array([one.receiver_m for one in traces]) + others_m) / 2.0
    places_m[[one.is_flat for one in traces], 1] = 0.0
    rotations_deg = [ROTATION_DEG[one.component] for one in traces]
    places_mm = np.round(places_m[:, 1::-1] * dataset.MM_PER_M, 6)
    return np.column_stack([rotations_deg, places_mm])


def _separation_m(file: str, traces: Sequence[_Trace]) -> Optional[float]:
    """Return the distance between the antennas [m]; None if it is not recorded."""
    apart = [one.receiver_m - one.source_m for one in traces if one.source_m is not None]
    if len(apart) < len(traces):
        return None
    apart_m = np.linalg.norm(np.array(apart)[:, : 1 if traces[0].is_flat else 2], axis=1)
    if np.ptp(apart_m) > SAME_M:
        raise refusal(
            Message(
                "{file}: source and receiver are {least_m:g} to {most_m:g} m apart; images need "
                "antennas that move together (equal #src_steps and #rx_steps)",
                file=file,
                least_m=apart_m.min(),
                most_m=apart_m.max(),
            )
        )
    return round(float(apart_m[0]), 9)


def _read(path: Path, spacing_m: Optional[float]) -> List[_Trace]:
    with opened_hdf5(path, "gprMax (HDF5)", RECEIVER) as file:
        fields = _fields(file, path)
        cells = file.attrs.get("nx_ny_nz")
        # Merged files of version 3 do not count their cells.
        only_ez = not any(np.any(fields[one]) for one in fields if one != "Ez")
        is_flat = only_ez if cells is None else int(cells[2]) == 1
        axis = file[SOURCE].attrs.get("Polarisation") if SOURCE in file else None
        along = _component(path, fields, is_flat, "" if axis is None else f"E{axis}")
        values = fields[along].T
        receivers_m, sources_m = _places(file, path, len(values), spacing_m)
        step_s = Header(path.name, file.attrs).number("dt", 1e-16, 1e-9)
        offset_s = _offset_s(file[RECEIVER][along])
        own = (path.name, along, is_flat)
        source = _excitation(file, path)
        return [
            _Trace(*own, Signal(one, step_s, offset_s), receiver_m, source_m, source)
            for one, receiver_m, source_m in zip(values, receivers_m, sources_m)
        ]


def _fields(file: Any, path: Path) -> Dict[str, np.ndarray]:
    """Return the electric fields of a file, each (time, trace)."""
    sources, receivers = (int(file.attrs.get(one, 1)) for one in ("nsrc", "nrx"))
    count = int(file.attrs["Iterations"])
    stored = {one: file[RECEIVER][one] for one in ROTATION_DEG if one in file[RECEIVER]}
    shapes = {field.shape for field in stored.values()}
    shape: Tuple[int, ...] = shapes.pop() if len(shapes) == 1 else ()
    fits = len(shape) == (1 if SOURCE in file else 2) and shape[0] == count and 0 not in shape
    if not fits or (sources, receivers) != (1, 1):
        raise refusal(
            Message(
                "{file} has {sources} sources, {receivers} receivers and fields of {shape} values; "
                "it must have one of each, which move together from trace to trace, and {count} "
                "values of each trace",
                file=path.name,
                sources=sources,
                receivers=receivers,
                shape=" x ".join(map(str, shape)) or "-",
                count=count,
            )
        )
    # With Python's integers, which do not overflow.
    size = BYTES_PER_SAMPLE * len(stored) * math.prod(map(int, shape))
    work.require_bytes(size, Message("reading {file}", file=path.name))
    return {
        one: np.asarray(field[()], np.float64).reshape(count, -1) for one, field in stored.items()
    }


def _component(path: Path, fields: Dict[str, np.ndarray], is_flat: bool, named: str) -> str:
    """Return the component of the field along the source, which must be horizontal."""
    strength = {one: float(np.abs(field).max()) for one, field in fields.items()}
    strength.pop("Ey" if is_flat else "Ez", None)
    along = named or max(strength, key=lambda one: strength[one], default="")
    # By the sum, since NaN is no maximum; infinities are refused too.
    if not (strength.get(along) and 0.0 < sum(strength.values()) < np.inf):
        raise refusal(
            Message(
                "{file}: the field along the source, {field}, is vertical, missing, zero or holds "
                "NaN; the source must be polarized along {horizontal}",
                file=path.name,
                field=along or "-",
                horizontal=Message("x or z, for y points upwards in a model of two dimensions")
                if is_flat
                else Message("x or y, for z points upwards"),
            )
        )
    return along


def _places(
    file: Any, path: Path, count: int, spacing_m: Optional[float]
) -> Tuple[np.ndarray, Sequence[Optional[np.ndarray]]]:
    """Return the places of receiver and source of each trace [m]; those of unknown sources None."""
    if SOURCE not in file and PLACES not in file:
        receiver, source, steps_m = (
            np.asarray(file.attrs.get(one, np.zeros(3)), np.float64)
            for one in ("rxsteps", "srcsteps", "dx_dy_dz")
        )
        if not np.array_equal(receiver, source):
            together = Message("{steps}, as #rx_steps: images need both", steps=str(receiver))
            raise Header(path.name, {"#src_steps": str(source)}).refused("#src_steps", together)
        steps_m = receiver * steps_m if spacing_m is None else np.array([spacing_m, 0.0, 0.0])
        if count > 1 and not steps_m[:2].any():
            raise needs_spacing(path, Message("the steps of the receiver are not recorded"))
        return np.arange(count)[:, np.newaxis] * steps_m, [None] * count
    if spacing_m is not None:
        raise AnalysisError(
            Message("{file} records its place; leave out --spacing", file=path.name)
        )
    if SOURCE in file:
        places = [np.array([file[one].attrs["Position"]]) for one in (RECEIVER, SOURCE)]
    else:
        places = [file[f"{PLACES}/{one}/Position"][()] for one in (RECEIVER, SOURCE)]
    if any(one.shape != (count, 3) or not np.isfinite(one).all() for one in places):
        three = Message("three numbers for each of {count} traces", count=count)
        shapes = " / ".join(str(one.shape) for one in places)
        raise Header(path.name, {"Position": shapes}).refused("Position", three)
    return places[0], list(places[1])


def _excitation(file: Any, path: Path) -> Optional[Signal]:
    if EXCITATION not in file:
        return None
    excitation = file[EXCITATION]
    values = np.asarray(excitation["samples"][()], np.float64).ravel()
    if not np.isfinite(values).all():
        raise refusal(Message("{file}: its source contains NaN", file=path.name))
    interval_s = Header(path.name, excitation.attrs).number("SampleInterval", 1e-16, 1e-9)
    return Signal(values, interval_s, _offset_s(excitation))


def _offset_s(recorded: Any) -> float:
    return float(recorded.attrs.get("TimeSampleOffset", 0.0))


def _whole(path: Path) -> Optional[Path]:
    files = _files(path) if path.is_dir() else [path]
    return path if files and hdf5_with(files[0], "rxs") else None


IMPORT = ImportFormat(
    read_gprmax, _whole, ("band", "height_m", "source", "spacing_m", "separation_m")
)
