"""The output of gprMax: one simulated A-scan per file, .out or, from version 4, .h5."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Optional, Tuple

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.mid import dataset
from gpr20_analysis.mid.formats.imported import Imported, as_dataset
from gpr20_analysis.mid.survey_grid import grid_of
from gpr20_analysis.mid.survey_source import Progress, silent

ROTATION_DEG: Dict[str, float] = {"Ex": 0.0, "Ey": 90.0}
NO_SOURCE = (
    "simulated by gprMax; the spectra are of the received field, in V/m per Hz: they hold the "
    "spectrum of the source, so their amplitudes are not those of S21"
)


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
    position_m: Tuple[float, float]
    step_s: float
    fields: Dict[str, np.ndarray]


def read_gprmax(
    path: Path, band: Band, height_m: Optional[float], progress: Progress = silent
) -> xr.Dataset:
    """Read the A-scans of a folder (or one file) and take their spectra.

    A sample lies halfway between source and receiver. Ex becomes 0 degrees and Ey 90 degrees; a
    component that is zero throughout the simulation is left out.

    Args:
        path: Folder of .out or .h5 files, or one of them.
        band: Frequencies of the spectra.
        height_m: Height of the antennas above the ground [m]; None if it is not known.
        progress: Shows how far it has come.

    Raises:
        AnalysisError: There is no such file.
        UnreadableFileError: One is damaged, or its time step cannot carry the band.
    """
    paths = [path] if path.is_file() else sorted([*path.glob("*.out"), *path.glob("*.h5")])
    if not paths:
        raise AnalysisError(f"{path} holds no .out or .h5 files of gprMax")
    traces = [_read(one) for one in progress(paths, len(paths))]
    components = [
        name for name in ROTATION_DEG if any(trace.fields[name].any() for trace in traces)
    ]
    if not components:
        raise UnreadableFileError(f"{path.name}: Ex and Ey are zero in every file")
    slowest_s = max(trace.step_s for trace in traces)
    if band.stop_hz >= 0.5 / slowest_s:
        raise UnreadableFileError(
            f"{path.name} has a time step of {slowest_s:g} s, which carries frequencies up to "
            f"{0.5 / slowest_s:g} Hz, not {band.stop_hz:g} Hz"
        )
    return _placed(path, traces, components, band, height_m)


def _placed(
    path: Path,
    traces: List[_Trace],
    components: List[str],
    band: Band,
    height_m: Optional[float],
) -> xr.Dataset:
    notes = [NO_SOURCE]
    # All components of a file lie at one place, so the grid is that of one of them.
    positions = np.array([(0.0, trace.position_m[1], trace.position_m[0]) for trace in traces]) * [
        1.0,
        dataset.MM_PER_M,
        dataset.MM_PER_M,
    ]
    grid = grid_of(positions, notes)
    cells = grid.places(positions)
    if len(set(cells)) < len(cells):
        raise UnreadableFileError(f"{path.name} holds two simulations of the same place")
    values = np.full((len(components), grid.cells, band.points), complex(np.nan, np.nan))
    for cell, trace in zip(cells, traces):
        for turn, name in enumerate(components):
            values[turn, cell] = _spectrum(trace.fields[name], trace.step_s, band.frequency_hz)
    shape = (len(components), *grid.shape[1:])
    return as_dataset(
        Imported(
            values.reshape(*shape, band.points),
            [ROTATION_DEG[name] for name in components],
            np.array(grid.y_mm) / dataset.MM_PER_M,
            np.array(grid.x_mm) / dataset.MM_PER_M,
            np.full(shape, np.nan if height_m is None else height_m),
            path.name,
            frequency_hz=band.frequency_hz,
            simulated=True,
            notes=notes,
        )
    )


def _spectrum(field: np.ndarray, step_s: float, frequency_hz: np.ndarray) -> np.ndarray:
    """Return the Fourier transform of a real signal, with the sign that S21 has."""
    time_s = np.arange(len(field)) * step_s
    return np.exp(-2j * np.pi * frequency_hz[:, np.newaxis] * time_s) @ field * step_s


def _read(path: Path) -> _Trace:
    try:
        with h5py.File(str(path), "r") as file:
            receiver, source = file["rxs/rx1"], file["srcs/src1"]
            fields = {
                name: np.asarray(receiver[name][()] if name in receiver else [0.0], np.float64)
                for name in ROTATION_DEG
            }
            middle = (np.array(receiver.attrs["Position"]) + source.attrs["Position"]) / 2.0
            step_s, count = float(file.attrs["dt"]), int(file.attrs["Iterations"])
    except (KeyError, OSError, RuntimeError, ValueError) as error:
        raise UnreadableFileError(f"{path.name} is no whole output of gprMax: {error}") from error
    for name, field in fields.items():
        if field.shape not in ((count,), (1,)) or not np.isfinite(field).all():
            raise UnreadableFileError(
                f"{path.name}: {name} has the shape {field.shape} or values that are no numbers; "
                f"{count} iterations were told"
            )
    return _Trace((float(middle[0]), float(middle[1])), step_s, fields)
