"""A survey from the traces of another instrument: places, time zero, separation, spacing."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Optional, Union

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.common import on_grid
from gpr20_analysis.formats.format import ImportOptions
from gpr20_analysis.formats.provenance import Facts
from gpr20_analysis.processing.antenna_delay import LONGEST_DELAY_S
from gpr20_analysis.read.antenna_attributes import (
    ANTENNA_DELAY,
    ANTENNA_SEPARATION,
    WIDEST_SEPARATION_M,
)
from gpr20_analysis.read.survey_grid import MAX_CELLS_PER_TRACE
from gpr20_analysis.sentences import with_notes
from gpr20_common.message import Message

NS_PER_S = 1e9
SHORTEST_STEP_S, LONGEST_STEP_S = 1e-13, 1e-7
FURTHEST_M = 1e7
DECIMALS = 6  # of millimetres: a place is what was meant, not the error of its sum
TRACES = ("spacing_m", "time_zero_s", "separation_m", "height_m", "band")
"""The options that the formats of other instruments take."""


@dataclass
class Traces:
    """What a file of another instrument holds.

    Attributes:
        path: The file or folder.
        values: (trace, sample), real over time or complex over frequency.
        step_s: Time between samples [s].
        start_s: Time of the first sample [s].
        zero_s: Time at which the pulse leaves the antennas [s]; None if it is not recorded.
        frequency_hz: Frequencies [Hz]; None over time.
        x_m: Place of each trace along X [m]; None if it is not recorded.
        y_m: Along Y [m].
        rotation_deg: Rotation of the antennas [deg].
        height_m: Antenna height [m]; NaN if unknown.
        separation_m: Distance between the antennas [m]; None if it is not recorded.
        simulated: Whether the data are simulated; None if unknown.
        facts: What is known of the survey besides.
        notes: What a user should know.
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
    height_m: Union[float, np.ndarray] = np.nan
    separation_m: Optional[float] = None
    simulated: Optional[bool] = None
    facts: Optional[Facts] = None
    notes: List[Message] = field(default_factory=list)


def as_survey(found: Traces, options: ImportOptions) -> xr.Dataset:
    """Return the Dataset of the traces; what the options give replaces what the file says.

    Raises:
        AnalysisError: The spacing is neither recorded nor given.
        UnreadableFileError: Times or places are wrong.
    """
    count, samples = found.values.shape
    positions = _positions(found, options, count)
    height_m = found.height_m if options.height_m is None else options.height_m
    delay_s = None
    if found.frequency_hz is None:
        delay_s = _delay_s(found, samples)
    data = on_grid(
        found.path.name,
        positions,
        found.values,
        np.broadcast_to(height_m, (count,)).tolist(),
        found.frequency_hz,
        found.notes,
        simulated=found.simulated,
        facts=found.facts,
        delay_s=delay_s,
    )
    zero_s = found.zero_s if options.time_zero_s is None else options.time_zero_s
    separation_m = found.separation_m if options.separation_m is None else options.separation_m
    attributes: Dict[str, Any] = {}
    notes: List[Message] = []
    if zero_s is not None:
        attributes[ANTENNA_DELAY] = _checked_zero_s(found, zero_s, delay_s)
    elif delay_s is not None and ANTENNA_DELAY not in data.attrs:
        notes.append(
            Message(
                "{file} does not record its time zero; 0 is used, so depths are too large; give "
                "--time-zero, or --delay to gpr20 image",
                file=found.path.name,
            )
        )
    if separation_m is not None:
        attributes[ANTENNA_SEPARATION] = _checked_separation_m(found, separation_m)
    data = data.assign_attrs(attributes)
    return data.assign_attrs(with_notes(data, notes)) if notes else data


def needs_spacing(path: Path, reason: Message) -> AnalysisError:
    """Return the error of traces whose places are not known."""
    return AnalysisError(
        Message(
            "{file}: {reason}; give the distance between traces with --spacing MM",
            file=path.name,
            reason=reason,
        ),
        fault=faults.OPTION,
    )


def _positions(found: Traces, options: ImportOptions, count: int) -> np.ndarray:
    """Return rotation [deg], y and x [mm] of each trace."""
    x_m, y_m = found.x_m, np.broadcast_to(found.y_m, (count,))
    if options.spacing_m is not None:
        x_m, y_m = np.arange(count) * options.spacing_m, np.zeros(count)
    if x_m is None:
        raise needs_spacing(found.path, Message("the places of the traces are not recorded"))
    places = np.stack([y_m, x_m], axis=1)
    wrong = ~(np.abs(places) <= FURTHEST_M).all(axis=1)
    if wrong.any():
        reason = Message("the place of trace {trace} is no length", trace=int(wrong.argmax()) + 1)
        raise needs_spacing(found.path, reason)
    if not y_m.any() and np.all(found.rotation_deg == 0.0):
        _check_ascending(found, x_m)
    rows, columns = (len({*np.round(one, DECIMALS).tolist()}) for one in (y_m, x_m))
    if count > 1 and (rows * columns == 1 or rows * columns > MAX_CELLS_PER_TRACE * count):
        raise needs_spacing(
            found.path, Message("the places of the traces are neither a line along X nor a grid")
        )
    rotation_deg = np.broadcast_to(found.rotation_deg, (count, 1))
    return np.hstack([rotation_deg, np.round(places * dataset.MM_PER_M, DECIMALS)])


def _check_ascending(found: Traces, x_m: np.ndarray) -> None:
    # A line is recorded in one direction: what goes back is a mistake of the wheel or the file.
    steps = np.diff(x_m)
    if steps.size and not (steps > 0.0).all():
        trace = int(np.argmin(steps > 0.0))
        raise needs_spacing(
            found.path,
            Message(
                "trace {trace} is at {x_m:g} m, but the one before it is at {before_m:g} m; "
                "places must ascend",
                trace=trace + 2,
                x_m=x_m[trace + 1],
                before_m=x_m[trace],
            ),
        )


def _delay_s(found: Traces, samples: int) -> np.ndarray:
    # Written so that NaN is refused too.
    if not (SHORTEST_STEP_S <= found.step_s <= LONGEST_STEP_S and samples >= 2):
        raise UnreadableFileError(
            Message(
                "{file} has {samples} samples in steps of {step_ns:g} ns; a trace of a radar has 2 "
                "or more in steps of {shortest_ns:g} to {longest_ns:g} ns",
                file=found.path.name,
                samples=samples,
                step_ns=found.step_s * NS_PER_S,
                shortest_ns=SHORTEST_STEP_S * NS_PER_S,
                longest_ns=LONGEST_STEP_S * NS_PER_S,
            ),
            fault=faults.FILE_CONTENT,
        )
    return found.start_s + np.arange(samples) * found.step_s


def _checked_zero_s(found: Traces, zero_s: float, delay_s: Optional[np.ndarray]) -> float:
    latest_s = LONGEST_DELAY_S if delay_s is None else min(LONGEST_DELAY_S, float(delay_s[-1]))
    if not 0.0 <= zero_s <= latest_s:
        raise UnreadableFileError(
            Message(
                "{file}: time zero is {zero_ns:g} ns; it must be in the record, from 0 to "
                "{latest_ns:g} ns; give the right one with --time-zero NS",
                file=found.path.name,
                zero_ns=zero_s * NS_PER_S,
                latest_ns=latest_s * NS_PER_S,
            ),
            fault=faults.FILE_CONTENT,
        )
    return zero_s


def _checked_separation_m(found: Traces, separation_m: float) -> float:
    if not 0.0 <= separation_m <= WIDEST_SEPARATION_M:
        raise UnreadableFileError(
            Message(
                "{file}: the antennas are {separation_m:g} m apart; it must be 0 to {widest_m:g} "
                "m; give the right distance with --separation M",
                file=found.path.name,
                separation_m=separation_m,
                widest_m=WIDEST_SEPARATION_M,
            ),
            fault=faults.FILE_CONTENT,
        )
    return separation_m
