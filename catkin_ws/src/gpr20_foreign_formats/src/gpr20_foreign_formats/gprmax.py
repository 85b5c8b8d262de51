"""The output of gprMax: one simulated A-scan per file, .out or, from version 4, .h5."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.formats.format import Band, ImportFormat, ImportOptions
from gpr20_analysis.processing.display import DISPLAY_ONLY
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.read.survey_attributes import ANTENNA_SEPARATION
from gpr20_analysis.sentences import sentences_of, with_sentence, with_sentences
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_foreign_formats.gprmax_merged import MERGED, ROTATION_DEG, merged_fields, time_step_s
from gpr20_foreign_formats.gprmax_source import NONE, Signal, check_strength, source_of
from gpr20_foreign_formats.header import no_files
from gpr20_survey.files.regular_file import check_regular

PATTERNS = ("*.out", "*.h5")
EXCITATION = "srcs/src1/excitation"
OFFSET = "TimeSampleOffset"
DIVIDED = Message(
    "simulated by gprMax; the spectra are the received field divided by the source signal, so "
    "delays are correct, but amplitudes are in V/m per unit of the source instead of S21"
)
WITH_SOURCE = Message(
    "the spectra contain the spectrum of the source, so every delay includes that of the source"
)


@dataclass(frozen=True)
class _Trace:
    name: str
    position: Tuple[float, float, float]
    """Rotation [deg], y and x [mm]."""
    field: Signal
    source: Optional[Signal]
    is_merged: bool = False


def read_gprmax(
    path: Path,
    band: Band,
    height_m: Optional[float],
    source: Optional[str] = None,
    progress: Progress = no_progress,
    spacing_m: Optional[float] = None,
) -> xr.Dataset:
    """Read the A-scans of a folder or of one file and compute their spectra.

    The position of a sample is halfway between source and receiver. Ex is 0 degrees and Ey 90
    degrees. The component along the source is used, which files of version 4 name; for version 3
    it is the strongest component. A file that gprMax's outputfiles_merge has made holds neither
    places nor source: its positions begin at 0, and its component is the strongest.

    Args:
        path: Folder of .out or .h5 files, or one of them.
        band: Frequencies of the spectra.
        height_m: Height of the antennas above the ground [m]; None if unknown.
        source: The signal that the spectra are divided by, see `source_of`; None: the source
            signal in the files, which version 4 writes.
        progress: Shows the progress.
        spacing_m: Distance between the traces of a merged file, along X [m]; None: its steps of
            the receiver.

    Raises:
        AnalysisError: There is no such file, or the source is unknown.
        UnreadableFileError: A file is damaged, or its time step or source does not cover the band.
    """
    paths = [path] if path.is_file() else sorted(_files(path))
    if not paths:
        raise no_files(path, ", ".join(PATTERNS))
    given = source_of(source) if source is not None else None
    traces = [one for file in progress(paths, len(paths)) for one in _read(file, spacing_m)]
    slowest_s = max(trace.field.step_s for trace in traces)
    if band.stop_hz >= 0.5 / slowest_s:
        raise UnreadableFileError(
            Message(
                "{file} has a time step of {step_s:g} s, which covers frequencies up to "
                "{highest_hz:g} Hz; give a --band that ends below that, not at {stop_hz:g} Hz",
                file=path.name,
                step_s=slowest_s,
                highest_hz=0.5 / slowest_s,
                stop_hz=band.stop_hz,
            ),
            fault=NOT_ALLOWED,
        )
    spectra = [_spectrum(trace, given, source == NONE, band.frequency_hz) for trace in traces]
    data = on_grid(
        path.name,
        np.array([trace.position for trace in traces]),
        spectra,
        [np.nan if height_m is None else height_m] * len(traces),
        band.frequency_hz,
        [MERGED] if any(trace.is_merged for trace in traces) else [],
        simulated=True,
    )
    if source == NONE:
        return data.assign_attrs(with_sentence(data.attrs, DISPLAY_ONLY, WITH_SOURCE))
    notes = [DIVIDED, *sentences_of(data, "notes")]
    return data.assign_attrs(with_sentences(data.attrs, notes=notes))


def _files(folder: Path) -> List[Path]:
    return [one for pattern in PATTERNS for one in folder.glob(pattern)]


def _spectrum(
    trace: _Trace, given: Optional[Signal], undivided: bool, frequency_hz: np.ndarray
) -> np.ndarray:
    spectrum = trace.field.spectrum(frequency_hz)
    if undivided:
        return spectrum
    source = given or trace.source
    if source is None:
        raise AnalysisError(
            Message(
                "{file} does not contain the source signal (gprMax version 4 writes it), so the "
                "delays are unknown; give --source, such as ricker:1.5e9 or a file of times and "
                "values, or --source {none} for spectra that can be displayed but not imaged",
                file=trace.name,
                none=NONE,
            ),
            fault=NOT_ALLOWED,
        )
    return spectrum / check_strength(source, frequency_hz, trace.name)


def _read(path: Path, spacing_m: Optional[float]) -> List[_Trace]:
    check_regular(path, follow_link=True)
    try:
        with h5py.File(str(path), "r") as file:
            if "srcs" not in file:
                merged = merged_fields(file, path, spacing_m)
                return [_Trace(path.name, place, field, None, True) for place, field in merged]
            if spacing_m is not None:
                raise AnalysisError(
                    Message("{file} records its place; leave out --spacing", file=path.name)
                )
            return [_trace(file, path.name)]
    except AnalysisError:
        raise
    # On damaged files HDF5 and numpy raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message(
                "{file} is damaged or is not an output of gprMax", file=path.name, details=error
            )
        ) from error


def _trace(file: Any, name: str) -> _Trace:
    sources, receivers = (int(file.attrs.get(one, 1)) for one in ("nsrc", "nrx"))
    if (sources, receivers) != (1, 1):
        raise UnreadableFileError(
            Message(
                "{file} has {sources} sources and {receivers} receivers; a sample needs one of "
                "each, which move together from file to file (#src_steps, #rx_steps)",
                file=name,
                sources=sources,
                receivers=receivers,
            ),
            fault=faults.INPUT,
        )
    receiver, source = file["rxs/rx1"], file["srcs/src1"]
    step_s, count = time_step_s(file, name), int(file.attrs["Iterations"])
    fields = {one: receiver[one] for one in ROTATION_DEG if one in receiver}
    for one, field in fields.items():
        if field.shape != (count,) or not np.isfinite(field[()]).all():
            raise UnreadableFileError(
                Message(
                    "{file}: {field} has the shape {shape} or NaN values; it must have {count} "
                    "values (use the single files instead of the merged one)",
                    file=name,
                    field=one,
                    shape=" x ".join(map(str, field.shape)),
                    count=count,
                ),
                fault=faults.INPUT,
            )
    along = _component(file, fields, name)
    middle_mm = (np.array(receiver.attrs["Position"]) + source.attrs["Position"]) / 2.0
    middle_mm = np.round(middle_mm * dataset.MM_PER_M, 6)
    return _Trace(
        name,
        (ROTATION_DEG[along], float(middle_mm[1]), float(middle_mm[0])),
        Signal(np.asarray(fields[along][()], np.float64), step_s, _offset_s(fields[along])),
        _excitation(file, step_s, name),
    )


def _component(file: Any, fields: Dict[str, Any], name: str) -> str:
    """Return the component of the field along the source."""
    axis = file["srcs/src1"].attrs.get("Polarisation")
    if axis is not None:
        along = f"E{axis}"
    else:
        strength = {one: float(np.abs(field[()]).max()) for one, field in fields.items()}
        along = max(strength, key=lambda one: strength[one]) if strength else ""
    if along not in fields or not np.any(fields[along][()]):
        raise UnreadableFileError(
            Message(
                "{file}: the field along the source ({field}) is missing or zero; the source must "
                "be polarized along x or y",
                file=name,
                field=along or "Ex, Ey",
            ),
            fault=faults.INPUT,
        )
    return along


def _excitation(file: Any, step_s: float, name: str) -> Optional[Signal]:
    if EXCITATION not in file:
        return None
    excitation = file[EXCITATION]
    values = np.asarray(excitation["samples"][()], np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise UnreadableFileError(
            Message("{file}: its source must be a row of numbers", file=name), fault=faults.INPUT
        )
    interval_s = float(excitation.attrs.get("SampleInterval", step_s))
    return Signal(values, interval_s, _offset_s(excitation))


def _offset_s(recorded: Any) -> float:
    return float(recorded.attrs.get(OFFSET, 0.0))


def _imported(path: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    data = read_gprmax(
        path, options.band or Band(), options.height_m, options.source, progress, options.spacing_m
    )
    if options.separation_m is None:
        return data
    return data.assign_attrs({ANTENNA_SEPARATION: options.separation_m})


def _whole(path: Path) -> Optional[Path]:
    files = _files(path) if path.is_dir() else [path]
    return path if files and _is_gprmax(files[0]) else None


def _is_gprmax(path: Path) -> bool:
    if path.suffix not in (".h5", ".hdf5", ".out") or not path.is_file():
        return False
    try:
        with h5py.File(str(path), "r") as file:
            return "rxs" in file
    # On damaged files HDF5 raises exceptions of many kinds; it is then none of gprMax.
    except Exception:
        return False


IMPORT = ImportFormat(
    _imported, _whole, ("band", "height_m", "source", "spacing_m", "separation_m")
)
