"""The output of gprMax: one simulated A-scan per file, .out or, from version 4, .h5."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.formats.gprmax_source import NONE, Signal, check_strength, source_of
from gpr20_analysis.processing.polarization import DISPLAY_ONLY
from gpr20_analysis.progress import Progress, silent

ROTATION_DEG: Dict[str, float] = {"Ex": 0.0, "Ey": 90.0}
EXCITATION = "srcs/src1/excitation"
OFFSET = "TimeSampleOffset"
DIVIDED = (
    "simulated by gprMax; the spectra are the received field over the source's signal, so delays "
    "are true and amplitudes are in V/m for each unit of the source, not those of S21"
)
WITH_SOURCE = "the spectra hold the spectrum of the source, so every delay is late by the source's"


@dataclass(frozen=True)
class Band:
    """The frequencies at which the spectra of simulated A-scans are taken [Hz]."""

    start_hz: float = 600e6
    stop_hz: float = 6e9
    points: int = 501

    @property
    def frequency_hz(self) -> np.ndarray:
        """The frequencies [Hz]."""
        return np.linspace(self.start_hz, self.stop_hz, self.points)


@dataclass(frozen=True)
class _Trace:
    name: str
    position: Tuple[float, float, float]
    """Rotation [deg], y and x [mm]."""
    field: Signal
    source: Optional[Signal]


def read_gprmax(
    path: Path,
    band: Band,
    height_m: Optional[float],
    source: Optional[str] = None,
    progress: Progress = silent,
) -> xr.Dataset:
    """Read the A-scans of a folder (or one file) and take their spectra.

    A sample lies halfway between source and receiver. Ex is 0 degrees and Ey 90 degrees; of a
    simulation the component along the source is taken, which version 4 tells; of version 3 the
    strongest.

    Args:
        path: Folder of .out or .h5 files, or one of them.
        band: Frequencies of the spectra.
        height_m: Height of the antennas above the ground [m]; None if it is not known.
        source: What the spectra are divided by, see `source_of`; None: by the source's signal in
            the files themselves, which version 4 writes.
        progress: Shows how far it has come.

    Raises:
        AnalysisError: There is no such file, or the source is not known.
        UnreadableFileError: One is damaged, or its time step or source cannot carry the band.
    """
    paths = [path] if path.is_file() else sorted([*path.glob("*.out"), *path.glob("*.h5")])
    if not paths:
        raise AnalysisError(f"{path} holds no .out or .h5 files of gprMax")
    given = source_of(source) if source is not None else None
    traces = [_read(one) for one in progress(paths, len(paths))]
    slowest_s = max(trace.field.step_s for trace in traces)
    if band.stop_hz >= 0.5 / slowest_s:
        raise UnreadableFileError(
            f"{path.name} has a time step of {slowest_s:g} s, which carries frequencies up to "
            f"{0.5 / slowest_s:g} Hz, not {band.stop_hz:g} Hz"
        )
    spectra = [_spectrum(trace, given, source == NONE, band.frequency_hz) for trace in traces]
    data = on_grid(
        path.name,
        np.array([trace.position for trace in traces]),
        spectra,
        [np.nan if height_m is None else height_m] * len(traces),
        band.frequency_hz,
        [],
        simulated=True,
    )
    if source == NONE:
        data.attrs[DISPLAY_ONLY] = WITH_SOURCE
    else:
        data.attrs["notes"] = [DIVIDED, *data.attrs["notes"]]
    return data


def _spectrum(
    trace: _Trace, given: Optional[Signal], undivided: bool, frequency_hz: np.ndarray
) -> np.ndarray:
    spectrum = trace.field.spectrum(frequency_hz)
    if undivided:
        return spectrum
    source = given or trace.source
    if source is None:
        raise AnalysisError(
            f"{trace.name} does not tell the signal of its source (version 4 of gprMax writes it), "
            "so delays cannot be told: give --source, such as ricker:1.5e9 or a file of times and "
            f"values, or --source {NONE} for spectra that can be looked at but not imaged"
        )
    return spectrum / check_strength(source, frequency_hz, trace.name)


def _read(path: Path) -> _Trace:
    try:
        with h5py.File(str(path), "r") as file:
            return _trace(file, path.name)
    except AnalysisError:
        raise
    # Whatever is changed in such a file, HDF5 and numpy raise errors of many kinds.
    except Exception as error:
        raise UnreadableFileError(f"{path.name} is no whole output of gprMax: {error}") from error


def _trace(file: Any, name: str) -> _Trace:
    for what, word in (("nsrc", "sources"), ("nrx", "receivers")):
        if int(file.attrs.get(what, 1)) != 1:
            raise UnreadableFileError(
                f"{name} has {int(file.attrs[what])} {word}; a sample is one source and one "
                "receiver, which move together from file to file (#src_steps, #rx_steps)"
            )
    receiver, source = file["rxs/rx1"], file["srcs/src1"]
    step_s, count = float(file.attrs["dt"]), int(file.attrs["Iterations"])
    fields = {one: receiver[one] for one in ROTATION_DEG if one in receiver}
    for one, field in fields.items():
        if field.shape != (count,) or not np.isfinite(field[()]).all():
            raise UnreadableFileError(
                f"{name}: {one} has the shape {field.shape} or values that are no numbers; {count} "
                "iterations were told (give the single files, not the merged one)"
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
    """Return the component of the field that lies along the source."""
    told = file["srcs/src1"].attrs.get("Polarisation")
    if told is not None:
        along = f"E{told}"
    else:
        strength = {one: float(np.abs(field[()]).max()) for one, field in fields.items()}
        along = max(strength, key=lambda one: strength[one]) if strength else ""
    if along not in fields or not np.any(fields[along][()]):
        raise UnreadableFileError(
            f"{name}: the field along the source ({along or 'Ex or Ey'}) is not there or zero; the "
            "source must be polarized along x or y"
        )
    return along


def _excitation(file: Any, step_s: float, name: str) -> Optional[Signal]:
    if EXCITATION not in file:
        return None
    told = file[EXCITATION]
    values = np.asarray(told["samples"][()], np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise UnreadableFileError(f"{name}: the samples of its source are no signal")
    return Signal(values, float(told.attrs.get("SampleInterval", step_s)), _offset_s(told))


def _offset_s(held: Any) -> float:
    return float(held.attrs.get(OFFSET, 0.0))
