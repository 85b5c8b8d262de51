"""The traces of a survey: the table in which they are collected, and the variables of a Dataset."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Collection, Dict, List, Optional, Sequence, Set, Tuple

import numpy as np

from gpr20_analysis.dataset import AXIS, HEIGHT, SAMPLE_DIMS
from gpr20_analysis.read.sources import Damage, Position
from gpr20_analysis.read.survey_attributes import OF_ANALYZER
from gpr20_analysis.read.survey_grid import Plan, planned_grid
from gpr20_analysis.work import require_bytes
from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import Zeros
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import TRACE_FIELDS, Trace
from gpr20_survey.trace.trace_form import FLOATS, TraceField
from gpr20_survey.trace.utc_time import NS_PER_US

EMPTY = complex(math.nan, math.nan)
_SINGLE = [one.attribute for one in TRACE_FIELDS if one.form is not FLOATS]
COLUMNS = {attribute: place for place, attribute in enumerate(_SINGLE)}
"""The places in a sample of what is not an array of the sweep, by their attributes."""
# They are coordinates, attributes, or the variables `aux_<name>`.
ELSEWHERE = ("format", "survey_id", "x_coord_mm", "y_coord_mm", "z_coord_deg", "aux")
NAMES = {"antennae_height_m": HEIGHT, "quality": "remarks"}
NEVER = np.datetime64("NaT", "ns")
COMPLEX_BYTES = 16


def empty_rows(samples: int, frequencies: int) -> np.ndarray:
    """Return the values (sample, frequency) of samples without data.

    Raises:
        TooLargeError: They do not fit into the memory.
    """
    require_bytes(samples * frequencies * COMPLEX_BYTES, Message("the survey"))
    return np.full((samples, frequencies), EMPTY, np.complex128)


@dataclass
class Sample:
    """A trace without its arrays, and the row of the table that has them."""

    row: int
    index: int
    position: Position
    columns: Tuple[Any, ...]
    """The values of COLUMNS."""
    analyzer: AnalyzerSettings
    zeros: Zeros
    content: int
    """The same for samples with the same values."""

    @classmethod
    def of(cls, trace: Trace, row: int) -> Sample:
        """Return the sample of a trace whose arrays are in a row."""
        values = trace.values()
        columns = tuple(values[attribute] for attribute in COLUMNS)
        content = hash((trace.s21_real.tobytes(), trace.s21_imag.tobytes()))
        return cls(
            row, trace.index, _position(trace), columns, trace.analyzer, trace.zeros, content
        )

    def __getitem__(self, attribute: str) -> Any:
        return self.columns[COLUMNS[attribute]]


class TraceTable:
    """Collects the traces of one Dataset; a trace that does not fit becomes a fault."""

    def __init__(self, count: int, plan: Optional[Plan]) -> None:
        self.faults: List[Damage] = []
        self.samples: Dict[int, Sample] = {}
        """The samples by index."""
        self.void: Set[int] = set()
        """Indices of samples that a later trace contradicts."""
        self.frequency_hz: Optional[np.ndarray] = None
        self.survey_id: Optional[str] = None
        self.other_frequencies = 0
        self.rows = np.empty((0, 0), np.complex128)
        """The values: in the order of the grid with a plan, else in the order of reading."""
        # With a plan the values are written to their place at once, which saves a copy.
        self._cells = planned_grid(plan).places(plan.positions) if plan else None
        self._capacity = max(count, 1) if plan is None else planned_grid(plan).cells
        self._repeated = 0

    def add(self, trace: Trace) -> None:
        """Add a trace, or add a fault that says why it does not fit."""
        if self.frequency_hz is None:
            self.frequency_hz = trace.frequency_hz
            self.survey_id = trace.survey_id
            self.rows = empty_rows(self._capacity, len(trace.frequency_hz))
        if trace.survey_id != self.survey_id:
            self.faults.append(Damage(of_other_survey(trace)))
        elif not np.array_equal(trace.frequency_hz, self.frequency_hz):
            self.other_frequencies += 1
            message = Message(
                "trace {index} has other frequencies ({own}) than the first trace ({first})",
                index=trace.index,
                own=_span(trace.frequency_hz),
                first=_span(self.frequency_hz),
                details=trace.sample_id,
            )
            self._refuse(trace, message)
        elif trace.index in self.samples:
            self._repeat(trace, self.samples[trace.index])
        else:
            self._take(trace)

    def notes(self) -> List[Message]:
        """Return notes on the survey as a whole."""
        if not self._repeated:
            return []
        return [
            Message(
                "{count} traces are stored more than once, with the same content",
                count=self._repeated,
            )
        ]

    def _take(self, trace: Trace) -> None:
        row = len(self.samples) if self._cells is None else int(self._cells[trace.index])
        if row >= len(self.rows):
            grown = empty_rows(2 * row, self.rows.shape[1])
            grown[:row] = self.rows
            self.rows = grown
        values = self.rows[row]
        values.real, values.imag = trace.s21_real, trace.s21_imag
        self.samples[trace.index] = Sample.of(trace, row)

    def _repeat(self, trace: Trace, taken: Sample) -> None:
        values = self.rows[taken.row]
        # As text, because NaN (a height that was not measured) is unequal to itself.
        if (
            repr(Sample.of(trace, taken.row)) == repr(taken)
            and np.array_equal(values.real, trace.s21_real)
            and np.array_equal(values.imag, trace.s21_imag)
        ):
            self._repeated += 1
            return
        self.void.add(trace.index)
        message = Message(
            "trace {index} is stored twice with different content; neither is used",
            index=trace.index,
            details=trace.sample_id,
        )
        self._refuse(trace, message)

    def _refuse(self, trace: Trace, message: Message) -> None:
        self.faults.append(Damage(message, trace.index, _position(trace)))


def of_other_survey(trace: Trace) -> Message:
    """Return the fault of a trace that belongs to another survey."""
    return Message(
        "trace {index} belongs to survey {survey}",
        index=trace.index,
        survey=trace.survey_id,
        details=trace.sample_id,
    )


def _position(trace: Trace) -> Position:
    return trace.z_coord_deg, trace.y_coord_mm, trace.x_coord_mm


def _span(frequency_hz: np.ndarray) -> Message:
    return Message(
        "{count} from {first_hz:g} to {last_hz:g} Hz",
        count=len(frequency_hz),
        first_hz=frequency_hz[0],
        last_hz=frequency_hz[-1],
    )


def trace_variables(
    samples: Sequence[Sample],
    cells: np.ndarray,
    shape: Tuple[int, ...],
    unknown_times: Collection[str],
) -> Dict[str, Tuple[Tuple[str, ...], np.ndarray]]:
    """Return dimensions and values of each variable.

    What no sample knows is left out, but for the height, and so is a setting of the analyzer that
    all samples share: it is an attribute.

    Args:
        samples: The samples.
        cells: The place of each in the flat grid.
        shape: Shape of the grid.
        unknown_times: Names of the times that the traces have because they must have some.
    """
    found = {}
    for one in TRACE_FIELDS:
        if one.attribute not in COLUMNS or one.name in ELSEWHERE:
            continue
        values = [sample[one.attribute] for sample in samples]
        name = NAMES.get(one.name, one.name)
        is_shared = name in OF_ANALYZER and len(set(values)) == 1
        if is_shared or (name != HEIGHT and all(map(one.is_unknown, values))):
            continue
        own, empty = _array(one, len(values) * [0] if name in unknown_times else values)
        placed = np.full((math.prod(shape), *own.shape[1:]), empty, own.dtype)
        placed[cells] = own
        dims = (*SAMPLE_DIMS, AXIS)[: len(shape) + own.ndim - 1]
        found[name] = dims, placed.reshape(*shape, *own.shape[1:])
    return found


def _array(field: TraceField, values: List[Any]) -> Tuple[np.ndarray, Any]:
    """Return an array, and what it holds where there is no sample or the value is not known."""
    kind = field.form.ros.partition("[")[0]
    if kind == "time":
        times_ns = np.array(values, np.int64) * NS_PER_US
        return np.where(times_ns == 0, NEVER, times_ns.astype("datetime64[ns]")), NEVER
    if kind == "string":
        texts = [one if isinstance(one, str) else "; ".join(one) for one in values]
        return np.array(texts, np.str_), ""
    if kind == "float64":
        return np.array([math.nan if field.is_unknown(one) else one for one in values]), math.nan
    return np.array(values, np.int64), -1 if field.unknown is None else field.unknown
