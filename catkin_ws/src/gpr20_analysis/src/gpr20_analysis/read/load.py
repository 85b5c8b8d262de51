"""Loads a survey of any form as one Dataset."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import AnalysisError, DamagedSurveyError
from gpr20_analysis.formats.dataset_files import NETCDF, checked, read_dataset
from gpr20_analysis.formats.facts import restored
from gpr20_analysis.formats.imports import refuse_device, refuse_importable
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.read.recordings import is_recording
from gpr20_analysis.read.sources import Damage, Position, SurveySource, open_source, read_trace
from gpr20_analysis.read.survey_attributes import OF_PEOPLE, aux_variables, survey_attributes
from gpr20_analysis.read.survey_grid import Plan, grid_of, planned_grid
from gpr20_analysis.read.traces import EMPTY, Sample, TraceTable, empty_rows, trace_variables
from gpr20_analysis.sentences import DECISIONS, NOTES, first_of, with_sentences
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message, verbatim
from gpr20_survey.folder.survey_folder import LOG_FILE
from gpr20_survey.plan.imported import TIMES_KNOWN, import_of, is_imported
from gpr20_survey.plan.recorded_plan import REFINES
from gpr20_survey.trace.trace import Trace

FAULTS_LISTED = 8
RECORDED = ("started", "ended", "outcome", "reason", "software_revision", REFINES)
MOST_KEPT_BYTES = 256 << 20
"""Of a survey that grows; further traces are read again each time."""


def load_survey(
    path: Union[str, Path], accept_damaged: bool = False, progress: Progress = no_progress
) -> xr.Dataset:
    """Load a survey as a Dataset, as `gpr20_analysis.dataset` describes it.

    Args:
        path: Folder of a survey, folder of its trace files, bag, MCAP, or a Dataset written by
            `gpr20` as .nc.
        accept_damaged: Leave damaged samples out, marked in `quality` and named in attribute
            `faults`, instead of refusing the survey. Samples that are merely missing are never
            refused: they are NaN, marked, and named in attribute `missing`.
        progress: Shows the progress.

    Returns:
        The Dataset; attribute `doubts` says what of it may not be believed.

    Raises:
        DamagedSurveyError: Something is damaged and that was not accepted.
        TooLargeError: The survey does not fit into the memory.
        AnalysisError: It is not a survey.
        OSError: It cannot be read.
    """
    found = Path(path).expanduser()
    refuse_device(found)
    if found.suffix == NETCDF:
        return checked(read_dataset(found), found.name, accept_damaged)
    # What is ours is not shown to the formats of other packages.
    if not (is_recording(found) or (found / LOG_FILE).exists()):
        refuse_importable(found)
    return assemble(open_source(found), accept_damaged, progress)


class GrowingSurvey:
    """A survey that is measured while it is looked at: traces are kept between two readings."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._kept: Dict[str, Tuple[Tuple[int, int], Trace]] = {}
        self._kept_bytes = 0

    def load(self) -> xr.Dataset:
        """Return what is stored now; damaged samples are left out and marked.

        Returns:
            The Dataset, as `load_survey` returns it.

        Raises:
            AnalysisError: It is no survey, or has no readable trace.
            OSError: It cannot be read.
        """
        return assemble(open_source(self.folder, self._read), accept_damaged=True)

    def _read(self, path: Path) -> Trace:
        status = path.stat()
        version = (status.st_mtime_ns, status.st_size)
        kept = self._kept.get(path.name)
        if kept is not None and kept[0] == version:
            return kept[1]
        trace = read_trace(path)
        if kept is not None or self._kept_bytes < MOST_KEPT_BYTES:
            self._kept_bytes += 0 if kept else 3 * trace.frequency_hz.nbytes
            self._kept[path.name] = version, trace
        return trace


def assemble(
    source: SurveySource,
    accept_damaged: bool = False,
    progress: Progress = no_progress,
) -> xr.Dataset:
    """Return the Dataset of a source, as `gpr20_analysis.dataset` describes it.

    Args:
        source: Where the traces come from.
        accept_damaged: Leave damaged samples out, marked, instead of refusing the survey.
        progress: Shows the progress.

    Raises:
        DamagedSurveyError: Something is damaged and that was not accepted, or no trace is left.
        AnalysisError: The source cannot be read at all.
    """
    plan = _plan(source)
    table = TraceTable(source.count, plan)
    for trace in progress(source.traces(), source.count or None):
        misplaced = plan.misplaced(trace) if plan else []
        if misplaced:
            table.faults += [Damage(message, trace.index) for message in misplaced]
        else:
            table.add(trace)
    _check_readable(source, table)
    assembly = _Assembly(source, plan, table)
    if assembly.faults and not accept_damaged:
        raise DamagedSurveyError(_refusal(source.name, assembly.faults))
    return assembly.dataset()


def _plan(source: SurveySource) -> Optional[Plan]:
    if source.description is None:
        source.notes.append(
            Message(
                "the log of the survey is not here, so the plan is unknown and missing rows at "
                "the edges cannot be detected"
            )
        )
        return None
    try:
        return Plan(source.description)
    except AnalysisError as error:
        source.faults.append(Damage(error.message))
        return None


def _check_readable(source: SurveySource, table: TraceTable) -> None:
    faults = source.faults + table.faults
    if not table.samples:
        message = Message("{source} contains no readable trace", source=source.name)
        if faults:
            message = Message("{fault}: {reason}", fault=message, reason=faults[0].message)
        raise DamagedSurveyError(message)
    if table.other_frequencies >= len(table.samples):
        raise DamagedSurveyError(
            Message(
                "{source} mixes frequencies: {count} traces differ from the first one, so the "
                "right frequencies are unknown; for example, {fault}",
                source=source.name,
                count=table.other_frequencies,
                fault=table.faults[0].message,
            )
        )


def _refusal(name: str, faults: List[Damage]) -> Message:
    return Message(
        "{source} is damaged: {faults}; check with `gpr20 verify` whether another "
        "recording of the survey is readable, or leave these samples out with --accept-damaged",
        source=name,
        faults=first_of([fault.message for fault in faults], FAULTS_LISTED),
    ).reporting_only(DamagedSurveyError.fault)


class _Assembly:
    """The samples of a table, placed on their grid."""

    def __init__(self, source: SurveySource, plan: Optional[Plan], table: TraceTable) -> None:
        self._source = source
        self._plan = plan
        imported = import_of(source.description or {})
        # Of an import: of a sample one time at most, and none of its sweep.
        self._unknown_times = {"sweep_started", "sweep_ended"} if imported else set()
        if imported and imported.get(TIMES_KNOWN) is not True:
            self._unknown_times.add(dataset.TIMESTAMP)
        self._table = table
        self._notes = source.notes + table.notes()
        self.faults = source.faults + table.faults
        samples = list(table.samples.values())
        positions = np.array([one.position for one in samples], np.float64)
        self._grid = planned_grid(plan) if plan else grid_of(positions, self._notes)
        self._used = self._usable(samples, self._grid.places(positions) if plan is None else None)
        self._cells = np.array([cell for cell, _ in self._used], np.int64)
        self._quality = np.full(self._grid.cells, int(Quality.MISSING), np.uint8)
        self._mark()

    def dataset(self) -> xr.Dataset:
        """Return the Dataset; see `assemble`."""
        shape, table = self._grid.shape, self._table
        variables: Dict[str, Any] = {
            dataset.S21: (dataset.S21_DIMS, self._ordered().reshape(*shape, -1))
        }
        samples = [sample for _, sample in self._used]
        variables.update(trace_variables(samples, self._cells, shape, self._unknown_times))
        variables[dataset.QUALITY] = (dataset.SAMPLE_DIMS, self._quality.reshape(shape))
        for name, (values, attributes) in self._aux().items():
            variables[name] = (dataset.SAMPLE_DIMS, values.reshape(shape), attributes)
        coordinates: Dict[str, Any] = {
            dataset.POLARIZATION: np.array(self._grid.polarization_deg),
            dataset.Y: np.array(self._grid.y_mm) / dataset.MM_PER_M,
            dataset.X: np.array(self._grid.x_mm) / dataset.MM_PER_M,
            dataset.FREQUENCY: table.frequency_hz,
        }
        if any(dataset.AXIS in one[0] for one in variables.values()):
            coordinates[dataset.AXIS] = list(dataset.AXES)
        found = dataset.described(xr.Dataset(variables, coordinates, self._attributes()))
        missing = dataset.missing_samples(found) + self._missing_by_index()
        return found.assign_attrs(with_sentences(found.attrs, missing=missing))

    def _usable(
        self, samples: List[Sample], cells: Optional[np.ndarray]
    ) -> List[Tuple[int, Sample]]:
        """Return the usable cells and samples; two samples in one cell become a fault."""
        by_cell: Dict[int, List[Sample]] = {}
        for number, sample in enumerate(samples):
            cell = sample.row if cells is None else int(cells[number])
            by_cell.setdefault(cell, []).append(sample)
        for same in by_cell.values():
            if len(same) > 1:
                message = Message(
                    "traces {indices} were measured at the same position and rotation; none of "
                    "them is used",
                    indices=", ".join(str(one.index) for one in same),
                )
                self.faults.append(Damage(message, position=same[0].position))
        return [
            (cell, same[0])
            for cell, same in by_cell.items()
            if len(same) == 1 and same[0].index not in self._table.void
        ]

    def _mark(self) -> None:
        for cell, sample in self._used:
            flags = Quality.REMARKED if sample["quality"] else Quality.GOOD
            if not np.isfinite(sample["antennae_height_m"]):
                flags |= Quality.NO_HEIGHT
            self._quality[cell] = int(flags)
        for fault in self.faults:
            position = self._damaged_position(fault)
            if position is not None:
                cell = self._grid.places(np.array([position]))[0]
                if self._quality[cell] & int(Quality.MISSING):
                    self._quality[cell] = int(Quality.DAMAGED)

    def _damaged_position(self, fault: Damage) -> Optional[Position]:
        if self._plan and fault.index is not None and fault.index < len(self._plan.points):
            z_deg, y_mm, x_mm = self._plan.positions[fault.index]
            return z_deg, y_mm, x_mm
        if fault.position is None:
            return None
        axes = (self._grid.polarization_deg, self._grid.y_mm, self._grid.x_mm)
        on_grid = all(value in axis for value, axis in zip(fault.position, axes))
        return fault.position if on_grid else None

    def _ordered(self) -> np.ndarray:
        """Return the data of each cell, NaN where there are none."""
        rows = self._table.rows
        if self._plan:
            taken = np.array([one.row for one in self._table.samples.values()])
            rows[np.setdiff1d(taken, self._cells)] = EMPTY
            return rows
        ordered = empty_rows(self._grid.cells, rows.shape[1])
        for cell, sample in self._used:
            ordered[cell] = rows[sample.row]
        return ordered

    def _aux(self) -> Dict[str, Tuple[np.ndarray, Dict[str, Any]]]:
        values = [sample["aux"] for _, sample in self._used]
        return aux_variables(values, self._cells, self._grid.cells, self._notes)

    def _missing_by_index(self) -> List[Message]:
        """Return the samples that are missing by their index but have no place in the grid."""
        if self._plan:
            return []
        indices = {sample.index for _, sample in self._used}
        absent = sorted(set(range(max(indices, default=-1) + 1)) - indices)
        unplaced = len(absent) - int(np.count_nonzero(self._quality & int(dataset.UNUSABLE)))
        if unplaced <= 0:
            return []
        return [
            Message(
                "missing: {count} samples at unknown positions, because indices {first} to {last} "
                "of the plan have gaps and the log of the survey is not here",
                count=unplaced,
                first=absent[0],
                last=absent[-1],
            )
        ]

    def _attributes(self) -> Dict[str, Any]:
        description = self._source.description or {}
        imported = import_of(description)
        kept = restored(xr.Dataset(), imported).attrs
        notes, decisions = (_texts(imported.get(name)) for name in (NOTES, DECISIONS))
        self._notes += notes
        attributes: Dict[str, Any] = {
            # What people add to a survey may have been changed since.
            **{name: value for name, value in kept.items() if name not in OF_PEOPLE},
            "format": dataset.FORMAT,
            "source": self._source.name,
            "survey_id": self._table.survey_id,
            **{word: str(description[word]) for word in RECORDED if description.get(word)},
            "stored": len(self._used),
            **survey_attributes(description, [one for _cell, one in self._used], self._notes),
        }
        faults = [fault.message for fault in self.faults]
        samples = list(self._table.samples.values())
        attributes = with_sentences(
            attributes,
            missing=[],
            faults=faults,
            doubts=survey_doubts(description, samples, len(faults)),
            notes=self._notes,
        )
        if decisions:
            attributes = with_sentences(attributes, decisions=decisions)
        if description:
            if "simulated" in description or not is_imported(description):
                attributes["simulated"] = int(bool(description.get("simulated")))
            attributes["survey_json"] = json.dumps(description)
        if self._plan and not is_imported(description):
            attributes["planned"] = len(self._plan.points)
        return attributes


def _texts(found: Any) -> List[Message]:
    return [verbatim(str(one)) for one in (found if isinstance(found, list) else [])]
