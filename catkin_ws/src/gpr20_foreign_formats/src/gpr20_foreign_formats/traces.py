"""A survey from the traces of another instrument: places, time zero, separation, spacing."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Union

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.read import survey_attributes
from gpr20_analysis.sentences import with_notes
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats.header import Header

STEP, ZERO = "sample interval [ns]", "time zero [ns] (--time-zero)"
SEPARATION, SPACING = "antenna separation [m] (--separation)", "trace spacing [mm] (--spacing)"
NS_PER_S = 1e9
SHORTEST_STEP_NS, LONGEST_STEP_NS = 1e-4, 100.0
LONGEST_SPACING_M, FURTHEST_M, LATEST_S = 1e3, 1e7, 1e-5
DECIMALS = 6  # of millimetres: a place is what was meant, not the error of its sum
TAKEN = ("spacing_m", "time_zero_s", "separation_m", "height_m", "band")
"""The options that all these formats take."""


@dataclass
class Traces:
    """What a file or folder of another instrument holds; None: it is not recorded.

    Attributes:
        values: (trace, sample), real over time or complex over frequency.
        start_s: Time of the first sample.
        zero_s: Time at which the pulse leaves the antennas.
        frequency_hz: None over time.
    """

    path: Path
    values: np.ndarray
    step_s: float = 0.0
    start_s: float = 0.0
    zero_s: Optional[float] = None
    frequency_hz: Optional[np.ndarray] = None
    x_m: Optional[np.ndarray] = None
    y_m: Union[float, np.ndarray] = 0.0
    rotation_deg: Union[float, np.ndarray] = 0.0
    separation_m: Optional[float] = None
    notes: List[Message] = field(default_factory=list)


def format_of(
    read: Callable[[Path, ImportOptions], Traces], *endings: str, takes: str = ""
) -> ImportFormat:
    """Return the format of files with these endings, by the function that reads one."""
    return ImportFormat(
        lambda path, options, _: as_survey(read(path, options), options),
        lambda path: path if path.suffix.lower() in endings and path.is_file() else None,
        (*TAKEN, takes) if takes else TAKEN,
    )


def as_survey(found: Traces, options: ImportOptions) -> xr.Dataset:
    """Return the Dataset of the traces; what the options give replaces what the file says.

    Raises:
        AnalysisError: The spacing is neither recorded nor given.
        UnreadableFileError: Times or places are wrong.
    """
    count, samples = found.values.shape
    height_m = np.nan if options.height_m is None else options.height_m
    zero_s = found.zero_s if options.time_zero_s is None else options.time_zero_s
    separation_m = found.separation_m if options.separation_m is None else options.separation_m
    zero_ns = None if zero_s is None else zero_s * NS_PER_S
    entries = {STEP: found.step_s * NS_PER_S, ZERO: zero_ns, SEPARATION: separation_m}
    checked = Header(found.path.name, entries)
    delay_s, latest_s = None, LATEST_S
    if found.frequency_hz is None:
        checked.number(STEP, SHORTEST_STEP_NS, LONGEST_STEP_NS)
        delay_s = found.start_s + np.arange(samples) * found.step_s
        latest_s = float(delay_s[-1])
    attributes: Dict[str, Any] = {}
    if zero_s is not None:
        checked.number(ZERO, 0.0, latest_s * NS_PER_S)
        attributes[survey_attributes.ANTENNA_DELAY] = zero_s
    if separation_m is not None:
        checked.number(SEPARATION, 0.0, survey_attributes.WIDEST_SEPARATION_M)
        attributes[survey_attributes.ANTENNA_SEPARATION] = separation_m
    data = on_grid(
        printable(found.path.name),
        _positions(found, options.spacing_m),
        found.values,
        [height_m] * count,
        found.frequency_hz,
        found.notes,
        delay_s=delay_s,
    ).assign_attrs(attributes)
    return data.assign_attrs(with_notes(data, _assumed(found.path.name, data)))


def _assumed(file: str, data: xr.Dataset) -> List[Message]:
    """Return notes on what neither the file nor the options say."""
    separation = Message(
        "{file} does not record the distance between the antennas; 0 is used, so shallow echoes "
        "appear too deep; give --separation",
        file=file,
    )
    zero_is_known = dataset.A_SCAN not in data or survey_attributes.ANTENNA_DELAY in data.attrs
    zero = Message(
        "{file} does not record its time zero; 0 is used, so depths are too large; give "
        "--time-zero, or --delay to gpr20 image",
        file=file,
    )
    notes = [] if zero_is_known else [zero]
    return notes if survey_attributes.ANTENNA_SEPARATION in data.attrs else [*notes, separation]


def needs_spacing(path: Path, reason: Message) -> AnalysisError:
    """Return the error of traces whose places are not known."""
    return AnalysisError(
        Message(
            "{file}: {reason}; give the distance between traces with --spacing MM",
            file=path.name,
            reason=reason,
        ),
        fault=NOT_ALLOWED,
    )


def _positions(found: Traces, spacing_m: Optional[float]) -> np.ndarray:
    """Return rotation [deg], y and x [mm] of each trace."""
    count = len(found.values)
    x_m, y_m = found.x_m, np.broadcast_to(found.y_m, (count,))
    if spacing_m is not None:
        given = Header(found.path.name, {SPACING: spacing_m * dataset.MM_PER_M})
        given.number(SPACING, 0.01, LONGEST_SPACING_M * dataset.MM_PER_M)
        goes_back = x_m is not None and x_m[-1] < x_m[0]
        x_m, y_m = np.arange(count)[:: -1 if goes_back else 1] * spacing_m, np.zeros(count)
    if x_m is None:
        raise needs_spacing(found.path, Message("the places of the traces are not recorded"))
    wrong = ~((np.abs(x_m) <= FURTHEST_M) & (np.abs(y_m) <= FURTHEST_M))
    if not (np.any(y_m) or np.any(found.rotation_deg)):
        # A line is recorded in one direction: what turns is an error of the wheel or the file.
        wrong[1:] |= np.diff(x_m) * np.sign(x_m[-1] - x_m[0]) <= 0.0
    if wrong.any():
        trace = int(wrong.argmax())
        reason = Message(
            "trace {trace} is at {x_m:g} m; places must be lengths that only ascend, or only "
            "descend, along a line",
            trace=trace + 1,
            x_m=x_m[trace],
        )
        raise needs_spacing(found.path, reason)
    places_mm = np.round(np.stack([y_m, x_m], axis=1) * dataset.MM_PER_M, DECIMALS)
    rotation_deg = np.broadcast_to(found.rotation_deg, (count,))
    return np.column_stack([rotation_deg, places_mm])
