"""A Dataset from the traces of a source."""

from __future__ import annotations

import json
from typing import Any, Dict, List, Optional

import numpy as np
import xarray as xr

from gpr20_analysis.errors import AnalysisError, DamagedSurveyError
from gpr20_analysis.mid import dataset
from gpr20_analysis.mid.coverage import Plan
from gpr20_analysis.mid.dataset import Quality
from gpr20_analysis.mid.row_order import arrange
from gpr20_analysis.mid.survey_grid import grid_of, planned_grid
from gpr20_analysis.mid.survey_source import Fault, Position, Progress, SurveySource, silent
from gpr20_analysis.mid.trace_table import Allocate, TraceTable, in_memory

FAULTS_TOLD = 8
WORDS = ("started", "ended", "outcome", "reason", "software_revision")
NS_PER_US = 1000


def assemble(
    source: SurveySource,
    accept_damaged: bool = False,
    progress: Progress = silent,
    allocate: Allocate = in_memory,
) -> xr.Dataset:
    """Return the Dataset of a source, as `gpr20_analysis.mid.dataset` describes it.

    Args:
        source: Where the traces come from.
        accept_damaged: Leave damaged samples out, marked, instead of refusing the survey.
        progress: Shows how far it has come.
        allocate: Makes the array of the numbers.

    Raises:
        DamagedSurveyError: Something is damaged and that was not accepted, or nothing is left.
        AnalysisError: The source cannot be read at all.
    """
    plan = _plan(source)
    capacity = len(plan.points) if plan else source.count
    table = TraceTable(max(capacity, source.count), allocate)
    for trace in progress(source.traces(), source.count or None):
        found = plan.misplaced(trace) if plan else []
        if found:
            table.faults += [Fault(text, trace.index) for text in found]
        else:
            table.add(trace)
    table.finish()
    _check_readable(source, table)
    return _Assembly(source, plan, table).dataset(accept_damaged, allocate)


def _plan(source: SurveySource) -> Optional[Plan]:
    if source.description is None:
        source.notes.append(
            "there is no survey.json with it: what was planned, and so whether rows are missing "
            "at the edges, cannot be told"
        )
        return None
    try:
        return Plan(source.description)
    except AnalysisError as error:
        source.faults.append(Fault(str(error)))
        return None


def _check_readable(source: SurveySource, table: TraceTable) -> None:
    faults = source.faults + table.faults
    if not table.samples:
        reason = f": {faults[0].text}" if faults else ""
        raise DamagedSurveyError(f"{source.name} holds no readable trace{reason}")
    if table.other_frequencies >= len(table.samples):
        raise DamagedSurveyError(
            f"{source.name} mixes frequencies: {table.other_frequencies} traces differ from the "
            f"first one, e.g. {table.faults[0].text}; which are right cannot be told"
        )


class _Assembly:
    def __init__(self, source: SurveySource, plan: Optional[Plan], table: TraceTable) -> None:
        self._source = source
        self._plan = plan
        self._table = table
        self._faults = source.faults + table.faults
        self._notes = source.notes + table.notes
        positions = np.array([sample.position for sample in table.samples], np.float64)
        self._grid = planned_grid(plan) if plan else grid_of(positions, self._notes)
        self._cells = self._grid.places(positions)
        self._quality = np.full(self._grid.cells, int(Quality.MISSING), np.uint8)
        self._used = self._usable_rows()

    def dataset(self, accept_damaged: bool, allocate: Allocate) -> xr.Dataset:
        """Return the Dataset; see `assemble`."""
        self._mark()
        if self._faults and not accept_damaged:
            raise DamagedSurveyError(self._refusal())
        rows = arrange(self._table.rows, self._cells, self._used, self._grid.cells, allocate)
        table = self._table
        shape = self._grid.shape
        samples: Dict[str, Any] = self._sample_variables()
        variables = {
            dataset.S21: (dataset.S21_DIMS, rows.reshape(*shape, -1)),
            **{
                name: (dataset.SAMPLE_DIMS, values.reshape(shape))
                for name, values in samples.items()
            },
        }
        coordinates = {
            dataset.POLARIZATION: np.array(self._grid.polarization_deg),
            dataset.Y: np.array(self._grid.y_mm) / dataset.MM_PER_M,
            dataset.X: np.array(self._grid.x_mm) / dataset.MM_PER_M,
            dataset.FREQUENCY: table.frequency_hz,
        }
        found = xr.Dataset(variables, coordinates, self._attributes())
        for name in found.variables:
            found[name].attrs.update(dataset.ATTRIBUTES.get(str(name), {}))
        found[dataset.QUALITY].attrs.update(dataset.QUALITY_ATTRIBUTES)
        found.attrs["missing"] = dataset.missing_samples(found) + self._missing_by_index()
        return found

    def _missing_by_index(self) -> List[str]:
        """Return what gaps in the indices tell of samples that the grid has no place for."""
        if self._plan:
            return []
        indices = {self._table.samples[row].index for row in self._used}
        absent = sorted(set(range(max(indices, default=-1) + 1)) - indices)
        unplaced = len(absent) - int(np.count_nonzero(self._quality & int(dataset.UNUSABLE)))
        if unplaced <= 0:
            return []
        return [
            f"missing: {unplaced} samples at places that only survey.json tells, since indices "
            f"{absent[0]}..{absent[-1]} of the plan have gaps"
        ]

    def _usable_rows(self) -> np.ndarray:
        """Return the rows whose numbers can be used, and name the cells that hold two."""
        rows = np.arange(len(self._cells))
        void = np.array([self._table.is_void(row) for row in rows], bool)
        cells, counts = np.unique(self._cells, return_counts=True)
        for cell in cells[counts > 1]:
            twice = rows[self._cells == cell]
            indices = [self._table.samples[row].index for row in twice]
            self._faults.append(
                Fault(
                    f"traces {', '.join(map(str, indices))} were taken at the same place and "
                    "rotation; none of them is used",
                    position=self._table.samples[twice[0]].position,
                )
            )
            void[twice] = True
        return rows[~void]

    def _mark(self) -> None:
        for row in self._used:
            sample = self._table.samples[row]
            flags = Quality.REMARKED if sample.remarks else Quality.GOOD
            if not np.isfinite(sample.height_m):
                flags |= Quality.NO_HEIGHT
            self._quality[self._cells[row]] = int(flags)
        for fault in self._faults:
            position = self._position(fault)
            if position is not None:
                cell = self._grid.places(np.array([position]))[0]
                if self._quality[cell] & int(Quality.MISSING):
                    self._quality[cell] = int(Quality.DAMAGED)

    def _position(self, fault: Fault) -> Optional[Position]:
        if self._plan and fault.index is not None and fault.index < len(self._plan.points):
            point = self._plan.points[fault.index]
            return point.z_deg, point.y_mm, point.x_mm
        position = fault.position
        if position is None:
            return None
        grid = self._grid
        held = zip(position, (grid.polarization_deg, grid.y_mm, grid.x_mm))
        return position if all(value in axis for value, axis in held) else None

    def _refusal(self) -> str:
        told = "; ".join(fault.text for fault in self._faults[:FAULTS_TOLD])
        more = len(self._faults) - FAULTS_TOLD
        return (
            f"{self._source.name} is damaged in {len(self._faults)} places: {told}"
            f"{f'; and {more} more' if more > 0 else ''}. `gpr20 verify` tells whether another "
            "recording of the survey is whole; --accept-damaged leaves these samples out, marked"
        )

    def _sample_variables(self) -> Dict[str, np.ndarray]:
        samples = [self._table.samples[row] for row in self._used]
        cells = self._cells[self._used]

        def spread(values: List[Any], empty: Any, kind: Any) -> np.ndarray:
            spread_out = np.full(self._grid.cells, empty, kind)
            spread_out[cells] = values
            return spread_out

        def moments(values: List[int]) -> np.ndarray:
            whole = spread(
                [one * NS_PER_US for one in values], np.datetime64("NaT").astype(int), np.int64
            )
            return whole.astype("datetime64[ns]")

        names = [one.sample_id for one in samples]
        remarks = ["; ".join(one.remarks) for one in samples]
        return {
            dataset.HEIGHT: spread([one.height_m for one in samples], np.nan, np.float64),
            dataset.TIMESTAMP: moments([one.timestamp_us for one in samples]),
            "sweep_started": moments([one.sweep_started_us for one in samples]),
            "sweep_ended": moments([one.sweep_ended_us for one in samples]),
            dataset.QUALITY: self._quality,
            "remarks": spread(remarks, "", f"<U{max(1, *map(len, remarks), 1)}"),
            "sample_id": spread(names, "", f"<U{max(1, *map(len, names), 1)}"),
            "index": spread([one.index for one in samples], -1, np.int64),
        }

    def _attributes(self) -> Dict[str, Any]:
        description = self._source.description or {}
        attributes: Dict[str, Any] = {
            "format": dataset.FORMAT,
            "source": self._source.name,
            "survey_id": self._table.survey_id,
            **{word: str(description[word]) for word in WORDS if description.get(word)},
            "stored": len(self._used),
            "missing": [],
            "faults": [fault.text for fault in self._faults],
            "notes": self._notes,
        }
        if description:
            attributes["simulated"] = int(bool(description.get("simulated")))
            attributes["survey_json"] = json.dumps(description)
        if self._plan:
            attributes["planned"] = len(self._plan.points)
        return attributes
