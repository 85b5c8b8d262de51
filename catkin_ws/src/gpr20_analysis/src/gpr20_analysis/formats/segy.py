"""SEG-Y revision 1: real A-scans over time, one file per polarization.

SEG-Y counts microseconds, but radar needs picoseconds: in these files a microsecond means a
picosecond, in the binary header and in every trace header, as the textual header says. A program
that knows nothing of it shows times a million times too long: 50 ps as 50 us. Inline is the row
(y), crossline the column (x). Coordinates and heights are in metres, stored as tenths of a
millimetre with scalar -10000.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
import pandas as pd
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats.facts import SIMULATED, is_simulated
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.sentences import DOUBTS, kept_doubts, sentences_of
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import storable
from gpr20_survey.radar.frequency_to_delay import delay_kernel

INTERVAL_PS = 50
PS_PER_S = 1e12
MOST_SAMPLES = 32767  # a signed 16-bit field
IEEE_FLOAT = 5
SCALAR = 10_000  # per metre
FURTHEST_M = 200_000  # a signed 32-bit field
LENGTH_UNITS, METRES, UTC = 1, 1, 4
LIVE, DEAD = 1, 2
UNIT_OF_TIME = "1 MICROSECOND IN THIS FILE MEANS 1 PICOSECOND"
MEASURED = "MEASURED DATA"
MOVED = "TIME ZERO OF EACH TRACE WAS MOVED: DELAYS ARE NOT THOSE OF THE ANTENNAS"
REVISION_BYTES = (3500, b"\x01\x00")  # place and content: revision 1.0
LINES, LINE_LENGTH = 40, 80


def file_of(path: Path, rotation_deg: float) -> Path:
    """Return the file of a polarization, such as NAME_090.sgy."""
    return path.with_name(f"{path.stem}_{round(float(rotation_deg)):03d}{path.suffix}")


def write_segy(survey: xr.Dataset, path: Path, progress: Progress = no_progress) -> int:
    """Write the one polarization of a survey and return the number of traces.

    A survey over frequency is transformed with a Hann window to steps of 50 ps over the unambiguous
    time; A-scans over time are written unchanged. A sample without data is a dead trace
    (identification code 2) of zeros.

    Raises:
        ExportError: The time step is not a whole number of picoseconds, there is more than one
            polarization, or a position does not fit.
        OSError: It cannot be written.
    """
    import segyio  # an optional library

    if survey.sizes[dataset.POLARIZATION] != 1:
        raise _refusal(
            Message("a SEG-Y file holds one polarization; select it with the step polarization")
        )
    survey = survey.isel({dataset.POLARIZATION: 0})
    usable = dataset.usable(survey).transpose(dataset.Y, dataset.X).values
    delay_s, traces = _a_scans(survey)
    traces[~usable] = 0.0
    interval_ps = _even_step(delay_s, "delay") * PS_PER_S
    if abs(interval_ps - round(interval_ps)) > 1e-3 or len(delay_s) > MOST_SAMPLES:
        raise _refusal(
            Message(
                "SEG-Y holds up to {most} samples in steps of whole picoseconds, not {count} in "
                "steps of {step_ps:g} ps; export the survey over frequency, which is transformed "
                "to fit",
                most=MOST_SAMPLES,
                count=len(delay_s),
                step_ps=interval_ps,
            )
        )
    headers = _headers(segyio.TraceField, survey, usable)
    if storable(path) != str(path):
        raise ExportError(
            Message("{folder} is no name in UTF-8; export to another folder", folder=path.parent)
        )
    segyio.tools.from_array(str(path), traces, format=IEEE_FLOAT, dt=round(interval_ps))
    with segyio.open(str(path), "r+") as file:
        file.text[0] = _text(survey, delay_s)
        field = segyio.BinField
        ones = (field.JobID, field.LineNumber, field.ReelNumber, field.Traces, field.EnsembleFold,
                field.SortingCode, field.TraceFlag)  # fmt: skip
        file.bin.update({**dict.fromkeys(ones, 1), field.MeasurementSystem: METRES})
        for number, header in enumerate(progress(headers, len(headers))):
            file.header[number].update(header)
    # Not by segyio, whose versions name this field differently.
    with path.open("r+b") as stream:
        stream.seek(REVISION_BYTES[0])
        stream.write(REVISION_BYTES[1])
    return len(headers)


def _refusal(message: Message) -> ExportError:
    return ExportError(message, fault=faults.INPUT)


def _even_step(values: np.ndarray, axis: str) -> float:
    """Return the spacing of evenly spaced coordinates; 0 for a single one."""
    steps = np.diff(values)
    if len(steps) and np.ptp(steps) > 0.01 * abs(steps.mean()):
        raise _refusal(
            Message(
                "the spacing of {axis} is uneven, {smallest:g} to {largest:g}; choose a format "
                "that supports that",
                axis=axis,
                smallest=steps.min(),
                largest=steps.max(),
            )
        )
    return float(steps.mean()) if len(steps) else 0.0


def _a_scans(survey: xr.Dataset) -> Tuple[np.ndarray, np.ndarray]:
    """Return delays [s] and real A-scans, float32 (y, x, delay)."""
    if dataset.A_SCAN in survey:
        values = survey[dataset.A_SCAN].transpose(dataset.Y, dataset.X, dataset.DELAY).values
        return survey[dataset.DELAY].values, values.real.astype(np.float32)
    if dataset.S21 not in survey:
        raise _refusal(
            Message("the data contain neither spectra nor A-scans; give data with one of them")
        )
    s21 = survey[dataset.S21].transpose(dataset.Y, dataset.X, dataset.FREQUENCY).values
    frequency_hz = survey[dataset.FREQUENCY].values
    count = int(PS_PER_S / _even_step(frequency_hz, "frequency") / INTERVAL_PS)
    delay_s = np.arange(min(count, MOST_SAMPLES)) * (INTERVAL_PS / PS_PER_S)
    # Evaluated at these delays, since the steps of an inverse FFT do not fit SEG-Y.
    kernel = delay_kernel(frequency_hz, delay_s)
    return delay_s, np.stack([(row @ kernel).real.astype(np.float32) for row in s21])


def _headers(field: Any, survey: xr.Dataset, usable: np.ndarray) -> List[Dict[int, int]]:
    """Return the header of each trace, in the order of the file."""
    for axis in (dataset.X, dataset.Y):
        furthest_m = float(np.abs(survey[axis].values).max())
        if not furthest_m <= FURTHEST_M:
            raise _refusal(
                Message(
                    "{axis} reaches {furthest_m:.10g} m, but SEG-Y holds positions up to {most_m} "
                    "m; use positions from a corner of the area",
                    axis=axis,
                    furthest_m=furthest_m,
                    most_m=FURTHEST_M,
                )
            )
    shape = (dataset.Y, dataset.X)
    heights = np.nan_to_num(survey[dataset.HEIGHT].transpose(*shape).values)
    times = np.full(heights.shape, "NaT", "datetime64[ns]")
    if dataset.TIMESTAMP in survey:
        times = survey[dataset.TIMESTAMP].transpose(*shape).values
    headers = []
    for number, (row, column) in enumerate(np.ndindex(*usable.shape), 1):
        x, y, height = (
            round(float(one) * SCALAR)
            for one in (survey[dataset.X][column], survey[dataset.Y][row], heights[row, column])
        )
        headers.append({
            field.ElevationScalar: -SCALAR,
            field.SourceGroupScalar: -SCALAR,
            field.CoordinateUnits: LENGTH_UNITS,
            field.DataUse: 1,  # production
            field.TimeBaseCode: UTC,
            field.TRACE_SEQUENCE_LINE: number,
            field.TRACE_SEQUENCE_FILE: number,
            field.CDP: number,
            field.CDP_TRACE: 1,
            field.FieldRecord: row + 1,
            field.TraceNumber: column + 1,
            field.TraceIdentificationCode: LIVE if usable[row, column] else DEAD,
            field.NStackedTraces: 1,
            field.offset: 0,
            field.ReceiverGroupElevation: height,
            field.SourceDepth: -height,
            **dict.fromkeys((field.SourceX, field.GroupX, field.CDP_X), x),
            **dict.fromkeys((field.SourceY, field.GroupY, field.CDP_Y), y),
            **_time(field, times[row, column]),
        })  # fmt: skip
    return headers


def _time(field: Any, moment: np.datetime64) -> Dict[Any, int]:
    if np.isnat(moment):
        return {}
    utc = pd.Timestamp(moment)
    return {
        field.YearDataRecorded: utc.year,
        field.DayOfYear: utc.dayofyear,
        field.HourOfDay: utc.hour,
        field.MinuteOfHour: utc.minute,
        field.SecondOfMinute: utc.second,
    }


def _doubts(survey: xr.Dataset) -> List[str]:
    """Return the doubts in lines as the textual header holds them, as far as there is room."""
    said = (f"DOUBTED: {one}" for one in kept_doubts(sentences_of(survey, DOUBTS)))
    lines = [line for one in said for line in textwrap.wrap(one.upper(), LINE_LENGTH - 4)]
    return [one.encode("ascii", "replace").decode() for one in lines][: LINES - 14]


def _text(survey: xr.Dataset, delay_s: np.ndarray) -> str:
    step_ps, first_ps = (round(one * PS_PER_S) for one in (delay_s[1] - delay_s[0], delay_s[0]))
    known = {True: f"{SIMULATED} DATA: THEY SHOW NO REAL GROUND", False: MEASURED}
    lines = {
        1: f"GPR-20 SURVEY {survey.attrs.get('survey_id', '')}",
        2: known[is_simulated(survey)] if "simulated" in survey.attrs else "",
        3: "STEPPED-FREQUENCY GROUND-PENETRATING RADAR, REAL A-SCANS OVER TWO-WAY DELAY",
        4: f"ANTENNAS AT {float(survey[dataset.POLARIZATION]):g} DEG",
        5: f"UNIT OF TIME: {UNIT_OF_TIME}",
        6: f"SAMPLE INTERVAL {step_ps} PS, {len(delay_s)} SAMPLES, THE FIRST AT {first_ps} PS",
        7: "INLINE = ROW (Y), CROSSLINE = COLUMN (X), BYTES 189 AND 193",
        8: "X AND Y IN METRES OF THE SCANNER, BYTES 73, 77, 81, 85, 181, 185, SCALAR -10000",
        9: "ANTENNA HEIGHT ABOVE GROUND IN METRES, BYTE 41, SCALAR -10000, 0 IF NOT KNOWN",
        10: "TRACES WITH IDENTIFICATION CODE 2 WERE NOT MEASURED OR ARE DAMAGED",
        11: "TIMES ARE UTC; YEAR 0 IF NOT KNOWN",
        12: MOVED if ADVANCE in survey else "",
        **dict(enumerate(_doubts(survey), 13)),
        LINES - 1: "SEG Y REV1",
        LINES: "END TEXTUAL HEADER",
    }
    return "".join(
        f"C{number:2d} {lines.get(number, '')}"[:LINE_LENGTH].ljust(LINE_LENGTH)
        for number in range(1, LINES + 1)
    )
