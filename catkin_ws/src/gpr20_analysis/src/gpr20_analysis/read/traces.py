"""The traces of a survey: their grid, the table that collects them, and variables of a Dataset."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Collection, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np

from gpr20_analysis import errors
from gpr20_analysis.dataset import AXIS, HEIGHT, HZ_PER_MHZ, SAMPLE_DIMS
from gpr20_analysis.errors import DamagedSurveyError
from gpr20_analysis.read.sources import Damage
from gpr20_analysis.read.survey_attributes import OF_ANALYZER
from gpr20_analysis.work import require_bytes
from gpr20_common.message import Message
from gpr20_survey.faults import DAMAGED
from gpr20_survey.plan.recorded_plan import ImportedGrid, PlanFit
from gpr20_survey.trace.trace import TRACE_FIELDS, Trace
from gpr20_survey.trace.trace_form import FLOATS, TraceField
from gpr20_survey.trace.utc_time import NS_PER_US

DECIMALS = 4  # of a millimetre: a hundredth of a motor step
EVEN = 0.1  # tolerance of even spacing, as a share of it; a motor step at 0.1 mm spacing
MAX_CELLS_PER_TRACE = 16
MAX_FILLING = 4


@dataclass(frozen=True)
class SurveyGrid(ImportedGrid):
    """Coordinates of a survey, each ascending."""

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Number of polarizations, rows and columns."""
        return len(self.polarization_deg), len(self.y_mm), len(self.x_mm)

    @property
    def cells(self) -> int:
        """Number of samples of a complete survey."""
        return len(self.polarization_deg) * len(self.y_mm) * len(self.x_mm)

    def places(self, positions: np.ndarray) -> np.ndarray:
        """Return the flat index of the grid cell of each position.

        Args:
            positions: (samples, 3), rotation [deg], y and x [mm]; each is on the grid.
        """
        flat = np.zeros(len(positions), np.int64)
        for column, axis in enumerate((self.polarization_deg, self.y_mm, self.x_mm)):
            own = np.round(np.array(axis), DECIMALS)
            flat = flat * len(axis) + np.searchsorted(own, np.round(positions[:, column], DECIMALS))
        return flat


def planned_positions(plan: PlanFit) -> np.ndarray:
    """Return rotation [deg], y and x [mm] of each planned sample, (samples, 3)."""
    return np.array([(one.z_deg, one.y_mm, one.x_mm) for one in plan.points])


def unknown_plan(reason: Message) -> Message:
    """Return the fault of a description whose plan is missing or invalid."""
    return Message("the plan is unknown: {reason}", reason=reason).reporting_only(DAMAGED)


def exact_grid(positions: np.ndarray) -> SurveyGrid:
    """Return the grid of positions that are those of all samples."""
    return SurveyGrid(*(_ascending(axis) for axis in positions.T.tolist()))


def grid_of(positions: np.ndarray, notes: List[Message]) -> SurveyGrid:
    """Return the grid of positions without a plan.

    Rows and columns without any sample are inserted where the spacing of the others shows a gap.

    Args:
        positions: (samples, 3), rotation [deg], y and x [mm].
        notes: Conclusions are added here.

    Raises:
        DamagedSurveyError: The positions do not form a grid.
    """
    found = exact_grid(positions)
    ys, xs = _filled(found.y_mm, "y", notes), _filled(found.x_mm, "x", notes)
    grid = SurveyGrid(found.polarization_deg, ys, xs)
    if grid.cells > MAX_CELLS_PER_TRACE * len(positions):
        raise DamagedSurveyError(
            Message(
                "{count} samples lie at {columns} different x and {rows} different y, which is "
                "not a grid; give the folder of the survey, whose log describes the grid",
                count=len(positions),
                columns=len(grid.x_mm),
                rows=len(grid.y_mm),
            ),
            fault=errors.INPUT,
        )
    return grid


def _ascending(values: Sequence[float]) -> Tuple[float, ...]:
    # Coordinates that round to the same value are one; the first is used unrounded.
    found: Dict[float, float] = {}
    for value in values:
        found.setdefault(round(value, DECIMALS) + 0.0, value)
    return tuple(found[key] for key in sorted(found))


def _filled(values: Tuple[float, ...], name: str, notes: List[Message]) -> Tuple[float, ...]:
    if len(values) < 3:
        return values
    spacings = np.diff(values)
    steps = spacings / spacings.min()
    whole = np.round(steps)
    if np.abs(steps - whole).max() > EVEN or whole.sum() > MAX_FILLING * len(values):
        notes.append(
            Message(
                "the spacing along {axis} is uneven: {smallest_mm:g} to {largest_mm:g} mm",
                axis=name,
                smallest_mm=spacings.min(),
                largest_mm=spacings.max(),
            )
        )
        return values
    if whole.max() == 1.0:
        return values
    filled: List[float] = [values[0]]
    for lower, upper, parts in zip(values, values[1:], whole.astype(int)):
        filled += [lower + (upper - lower) * part / parts for part in range(1, parts)] + [upper]
    notes.append(
        Message(
            "{count} positions along {axis} without any sample were inserted to make the spacing "
            "even",
            count=len(filled) - len(values),
            axis=name,
        )
    )
    return tuple(filled)


EMPTY = complex(math.nan, math.nan)
ARRAYS = {one.attribute for one in TRACE_FIELDS if one.form is FLOATS}
# They are coordinates, attributes, or the variables `aux_<name>`.
ELSEWHERE = {"format", "survey_id", "x_coord_mm", "y_coord_mm", "z_coord_deg", "aux", *ARRAYS}
NAMES = {"antennae_height_m": HEIGHT, "quality": "remarks"}
NEVER = np.datetime64("NaT", "ns")


def empty_rows(samples: int, frequencies: int) -> np.ndarray:
    """Return the values (sample, frequency) of samples without data.

    Raises:
        TooLargeError: They do not fit into the memory.
    """
    require_bytes(samples * frequencies * np.dtype(np.complex128).itemsize, Message("the survey"))
    return np.full((samples, frequencies), EMPTY, np.complex128)


@dataclass
class Sample:
    """A trace without its arrays, and the row of the table that has them."""

    row: int
    values: Mapping[str, Any]
    """Of each attribute of a trace that is no array."""
    content: int
    """The same for samples with the same values of S21."""

    @classmethod
    def of(cls, trace: Trace, row: int) -> Sample:
        """Return the sample of a trace whose arrays are in a row."""
        values = {name: one for name, one in trace.values().items() if name not in ARRAYS}
        return cls(row, values, hash((trace.s21_real.tobytes(), trace.s21_imag.tobytes())))

    def __getitem__(self, attribute: str) -> Any:
        return self.values[attribute]

    @property
    def index(self) -> int:
        """Index of the trace in the survey's plan."""
        return int(self["index"])

    @property
    def position(self) -> Tuple[float, float, float]:
        """Rotation [deg], y and x [mm]."""
        return self["z_coord_deg"], self["y_coord_mm"], self["x_coord_mm"]


class TraceTable:
    """Collects the traces of one Dataset; a trace that does not fit becomes a fault."""

    def __init__(self, plan: Optional[PlanFit]) -> None:
        self.faults: List[Damage] = []
        self.samples: Dict[int, Sample] = {}
        """The samples by index."""
        self.frequency_hz: Optional[np.ndarray] = None
        self.survey_id: Optional[str] = None
        self.other_frequencies = self.repeated = 0
        self._plan = plan
        self._void: Set[int] = set()
        """Indices of samples that a later trace contradicts."""
        # With a plan the values are written to their place at once, which saves a copy.
        self._grid: Optional[SurveyGrid] = None
        self._cells: Optional[np.ndarray] = None
        if plan:
            positions = planned_positions(plan)
            self._grid = exact_grid(positions)
            self._cells = self._grid.places(positions)
        self._rows: Any = {}

    def add(self, trace: Trace) -> None:
        """Add a trace, or add a fault that says why it does not fit."""
        misplaced = self._plan.misplaced(trace) if self._plan else []
        if misplaced:
            self.faults += [Damage(message, trace.index) for message in misplaced]
            return
        if self.frequency_hz is None:
            self.frequency_hz = trace.frequency_hz
            self.survey_id = trace.survey_id
            if self._grid:
                self._rows = empty_rows(self._grid.cells, len(trace.frequency_hz))
        if trace.survey_id != self.survey_id:
            self.faults.append(Damage(of_other_survey(trace)))
        elif not np.array_equal(trace.frequency_hz, self.frequency_hz):
            self.other_frequencies += 1
            message = Message(
                "trace {index} has other frequencies than the first trace: {count} from "
                "{first_mhz:g} to {last_mhz:g} MHz",
                index=trace.index,
                count=len(trace.frequency_hz),
                first_mhz=trace.frequency_hz[0] / HZ_PER_MHZ,
                last_mhz=trace.frequency_hz[-1] / HZ_PER_MHZ,
                details=trace.sample_id,
            )
            self.faults.append(Damage(message, trace.index))
        elif trace.index in self.samples:
            self._repeat(trace, self.samples[trace.index])
        else:
            row = len(self.samples) if self._cells is None else int(self._cells[trace.index])
            values = np.empty(len(trace.frequency_hz), np.complex128)
            values.real, values.imag = trace.s21_real, trace.s21_imag
            self._rows[row] = values
            self.samples[trace.index] = Sample.of(trace, row)

    def _repeat(self, trace: Trace, taken: Sample) -> None:
        # As text, because NaN (a height that was not measured) is unequal to itself.
        if repr(Sample.of(trace, taken.row)) == repr(taken):
            self.repeated += 1
            return
        self._void.add(trace.index)
        message = Message(
            "trace {index} is stored twice with different content; neither is used",
            index=trace.index,
            details=trace.sample_id,
        )
        self.faults.append(Damage(message, trace.index))

    def placed(self, notes: List[Message]) -> Tuple[SurveyGrid, Dict[int, Sample]]:
        """Return the grid, and the usable sample of each cell; two in one cell become a fault.

        Args:
            notes: What is concluded of the grid is added here.
        """
        samples = list(self.samples.values())
        grid, cells = self._grid, [one.row for one in samples]
        if grid is None:
            positions = np.array([one.position for one in samples], np.float64)
            grid = grid_of(positions, notes)
            cells = grid.places(positions).tolist()
        by_cell: Dict[int, List[Sample]] = {}
        for cell, sample in zip(cells, samples):
            by_cell.setdefault(cell, []).append(sample)
        for same in by_cell.values():
            if len(same) > 1:
                message = Message(
                    "traces {indices} were measured at the same position and rotation; none of "
                    "them is used",
                    indices=", ".join(str(one.index) for one in same),
                )
                self.faults.append(Damage(message))
        alone = {cell: same[0] for cell, same in by_cell.items() if len(same) == 1}
        return grid, {cell: one for cell, one in alone.items() if one.index not in self._void}

    def ordered(self, placed: Mapping[int, Sample], cells: int) -> np.ndarray:
        """Return the values (cell, frequency) of these samples, NaN where there is none."""
        if self._grid:
            for sample in self.samples.values():
                if sample.row not in placed:
                    self._rows[sample.row] = EMPTY
            return np.asarray(self._rows)
        rows = empty_rows(cells, 0 if self.frequency_hz is None else len(self.frequency_hz))
        for cell, sample in placed.items():
            rows[cell] = self._rows[sample.row]
        return rows

    def cell_of(self, index: int) -> Optional[int]:
        """Return the cell of a planned trace; None: without a plan it is not known."""
        cells = self._cells
        return int(cells[index]) if cells is not None and index < len(cells) else None


def of_other_survey(trace: Trace) -> Message:
    """Return the fault of a trace that belongs to another survey."""
    return Message(
        "trace {index} belongs to survey {survey}",
        index=trace.index,
        survey=trace.survey_id,
        details=trace.sample_id,
    )


def trace_variables(
    samples: Sequence[Sample],
    cells: Sequence[int],
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
        if one.attribute in ELSEWHERE:
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
