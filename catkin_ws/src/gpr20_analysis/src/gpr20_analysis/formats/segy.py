"""SEG-Y: real A-scans over time, one file per polarization.

SEG-Y counts microseconds, but radar needs picoseconds: the interval field contains picoseconds, as
the textual header says. Inline is the row (y), crossline the column (x); coordinates are in
millimetres with scalar -1000, that is metres.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import ExportError, MissingLibraryError, library_missing
from gpr20_analysis.formats.common import even_step
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message

INTERVAL_PS = 50
PS_PER_S = 1e12
MOST_SAMPLES = 32767  # a signed 16-bit field
IEEE_FLOAT = 5
CROSSLINE_SORTING = 1


def file_of(path: Path, rotation_deg: float) -> Path:
    """Return the file of a polarization, such as NAME_090.sgy; NAME_combined.sgy for both."""
    word = "combined" if np.isnan(rotation_deg) else f"{round(float(rotation_deg)):03d}"
    return path.with_name(f"{path.stem}_{word}{path.suffix}")


def write_segy(survey: xr.Dataset, path: Path, progress: Progress = no_progress) -> int:
    """Write the one polarization of a survey and return the number of traces.

    A survey over frequency is transformed with a Hann window to steps of 50 ps over the unambiguous
    time; A-scans over time are written unchanged. A sample without data is a dead trace
    (identification code 2) of zeros.

    Raises:
        MissingLibraryError: segyio is not installed.
        ExportError: The time step is not a whole number of picoseconds, or there is more than one
            polarization.
        OSError: It cannot be written.
    """
    segyio = _segyio()
    if survey.sizes[dataset.POLARIZATION] != 1:
        raise ExportError(
            Message("a SEG-Y file holds one polarization; write each to a separate file")
        )
    survey = survey.isel({dataset.POLARIZATION: 0})
    if dataset.S21 not in survey and dataset.A_SCAN not in survey:
        raise ExportError(
            Message("the data contain neither spectra nor A-scans, so they cannot be exported")
        )
    if dataset.A_SCAN in survey:
        delay_s = survey[dataset.DELAY].values
    else:
        delay_s = _delays_s(survey)
    interval_ps = even_step(delay_s, Message("delay"), "s") * PS_PER_S
    if abs(interval_ps - round(interval_ps)) > 1e-3 or len(delay_s) > MOST_SAMPLES:
        raise ExportError(
            Message(
                "SEG-Y holds up to {most} samples in steps of whole picoseconds, not {count} in "
                "steps of {step_ps:g} ps; export the survey over frequency, which is transformed "
                "to fit",
                most=MOST_SAMPLES,
                count=len(delay_s),
                step_ps=interval_ps,
            )
        )
    spec = segyio.spec()
    spec.format, spec.sorting = IEEE_FLOAT, CROSSLINE_SORTING
    spec.samples = np.arange(len(delay_s)) * round(interval_ps) / 1000.0
    spec.ilines = np.arange(1, survey.sizes[dataset.Y] + 1)
    spec.xlines = np.arange(1, survey.sizes[dataset.X] + 1)
    traces = _a_scans(survey, delay_s)
    with segyio.create(str(path), spec) as file:
        _fill(segyio, file, survey, traces, interval_ps, progress)
    return survey.sizes[dataset.Y] * survey.sizes[dataset.X]


def _segyio() -> Any:
    try:
        import segyio
    except ImportError as error:
        raise MissingLibraryError(library_missing("segyio", "segy")) from error
    return segyio


def _delays_s(survey: xr.Dataset) -> np.ndarray:
    step_hz = even_step(survey[dataset.FREQUENCY].values, Message("frequency"), "Hz")
    count = int(PS_PER_S / step_hz / INTERVAL_PS)
    return np.arange(min(count, MOST_SAMPLES)) * (INTERVAL_PS / PS_PER_S)


def _a_scans(survey: xr.Dataset, delay_s: np.ndarray) -> np.ndarray:
    """Return real A-scans, float32 (y, x, delay)."""
    if dataset.A_SCAN in survey:
        values = survey[dataset.A_SCAN].transpose(dataset.Y, dataset.X, dataset.DELAY).values
        return values.real.astype(np.float32)
    s21 = survey[dataset.S21].transpose(dataset.Y, dataset.X, dataset.FREQUENCY)
    # Evaluated at these delays, since the steps of an inverse FFT do not fit SEG-Y.
    frequency_hz = survey[dataset.FREQUENCY].values
    weights = np.hanning(len(frequency_hz) + 2)[1:-1]
    turns = np.exp(2j * np.pi * frequency_hz[:, np.newaxis] * delay_s) / weights.sum()
    turns *= weights[:, np.newaxis]
    rows = [(np.asarray(s21[row]) @ turns).real.astype(np.float32) for row in range(len(s21))]
    return np.stack(rows)


def _fill(
    segyio: Any,
    file: Any,
    survey: xr.Dataset,
    traces: np.ndarray,
    interval_ps: float,
    progress: Progress,
) -> None:
    field = segyio.TraceField
    file.text[0] = segyio.tools.create_text_header(_text(survey, interval_ps))
    file.bin.update({segyio.BinField.Interval: round(interval_ps), segyio.BinField.Format: 5})
    usable = dataset.usable(survey).transpose(dataset.Y, dataset.X).values
    places = list(np.ndindex(*usable.shape))
    for number, (row, column) in enumerate(progress(places, len(places))):
        x_mm, y_mm = (
            round(float(survey[axis].values[place]) * dataset.MM_PER_M)
            for axis, place in ((dataset.X, column), (dataset.Y, row))
        )
        file.header[number] = {
            field.TRACE_SEQUENCE_LINE: number + 1,
            field.TraceIdentificationCode: 1 if usable[row, column] else 2,
            field.INLINE_3D: row + 1,
            field.CROSSLINE_3D: column + 1,
            field.SourceGroupScalar: -1000,
            **dict.fromkeys((field.SourceX, field.GroupX, field.CDP_X), x_mm),
            **dict.fromkeys((field.SourceY, field.GroupY, field.CDP_Y), y_mm),
            field.TRACE_SAMPLE_INTERVAL: round(interval_ps),
        }
        file.trace[number] = np.where(usable[row, column], traces[row, column], np.float32(0.0))


def _text(survey: xr.Dataset, interval_ps: float) -> Any:
    simulated = "SIMULATED DATA" if survey.attrs.get("simulated") else ""
    return {
        1: f"GPR-20 SURVEY {survey.attrs.get('survey_id', '')}",
        2: f"ANTENNAS AT {float(survey[dataset.POLARIZATION]):g} DEG {simulated}",
        3: f"SAMPLE INTERVAL IS IN PICOSECONDS: {round(interval_ps)} PS",
        4: "INLINE = ROW (Y), CROSSLINE = COLUMN (X); COORDINATES IN MM, SCALAR -1000",
        5: "TRACES WITH IDENTIFICATION CODE 2 WERE NOT MEASURED OR ARE DAMAGED",
    }
