"""Loads a survey of any form as one Dataset."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple, Union

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import DamagedSurveyError
from gpr20_analysis.formats.dataset_files import NETCDF, checked, read_dataset
from gpr20_analysis.formats.imports import refuse_device, refuse_importable
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.read.recordings import is_recording
from gpr20_analysis.read.sources import Damage, Source, open_source
from gpr20_analysis.read.survey_attributes import (
    OF_PEOPLE,
    aux_variables,
    imported_attributes,
    survey_attributes,
)
from gpr20_analysis.read.traces import Sample, TraceTable, trace_variables, unknown_plan
from gpr20_analysis.sentences import DECISIONS, NOTES, first_of, with_sentences
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_survey.folder.survey_folder import LOG_FILE
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.plan.recorded_plan import REFINES, TIMES_KNOWN, PlanFit, import_of, is_imported
from gpr20_survey.trace.trace import Trace

FAULTS_LISTED = 8
MOST_KEPT_BYTES = 256 << 20
"""Of a survey that grows; further traces are read again each time."""
RECORDED = ("started", "ended", "outcome", "reason", "software_revision", REFINES)


def load_survey(
    path: Union[str, Path], accept_damaged: bool = False, progress: Progress = no_progress
) -> xr.Dataset:
    """Load a survey as a Dataset, as `gpr20_analysis.dataset` describes it.

    Args:
        path: Folder of a survey, folder of its trace files, bag, MCAP, or a Dataset written by
            `gpr20` as .nc.
        accept_damaged: Leave damaged samples out, marked in `quality` and named in attribute
            `faults`, instead of refusing the survey; a damaged .nc is always refused. Samples that
            are merely missing never are: they are NaN, marked, and named in attribute `missing`.
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
        return checked(read_dataset(found), found.name)
    # What is ours is not shown to the formats of other packages.
    if not (is_recording(found) or (found / LOG_FILE).exists()):
        refuse_importable(found)
    return assemble(open_source(found), accept_damaged, progress)


class GrowingSurvey:
    """A survey that is measured while it is looked at: traces are kept between two readings."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._kept: Dict[str, Tuple[Tuple[int, int], Trace]] = {}

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
        if kept is not None or 3 * len(self._kept) * trace.frequency_hz.nbytes < MOST_KEPT_BYTES:
            self._kept[path.name] = version, trace
        return trace


def assemble(
    source: Source, accept_damaged: bool = False, progress: Progress = no_progress
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
    table = TraceTable(plan)
    for trace in progress(source.traces(), source.count):
        table.add(trace)
    _check_readable(source, table)
    notes = list(source.notes)
    if table.repeated:
        notes.append(
            Message(
                "{count} traces are stored more than once, with the same content",
                count=table.repeated,
            )
        )
    grid, placed = table.placed(notes)
    faults = source.faults + table.faults
    if faults and not accept_damaged:
        raise DamagedSurveyError(_refusal(source.name, faults))
    cells, samples = list(placed), list(placed.values())
    quality = _quality(table, grid.cells, faults, placed)
    unknown = _unknown_times(import_of(source.description or {}))
    variables: Dict[str, Any] = {
        dataset.S21: (dataset.S21_DIMS, table.ordered(placed, grid.cells).reshape(*grid.shape, -1)),
        **trace_variables(samples, cells, grid.shape, unknown),
        dataset.QUALITY: (dataset.SAMPLE_DIMS, quality.reshape(grid.shape)),
    }
    aux = [one["aux"] for one in samples]
    for name, (values, own) in aux_variables(aux, cells, grid.cells, notes).items():
        variables[name] = (dataset.SAMPLE_DIMS, values.reshape(grid.shape), own)
    coordinates: Dict[str, Any] = {
        dataset.POLARIZATION: np.array(grid.polarization_deg),
        dataset.Y: np.array(grid.y_mm) / dataset.MM_PER_M,
        dataset.X: np.array(grid.x_mm) / dataset.MM_PER_M,
        dataset.FREQUENCY: table.frequency_hz,
    }
    if any(dataset.AXIS in one[0] for one in variables.values()):
        coordinates[dataset.AXIS] = list(dataset.AXES)
    found = dataset.described(xr.Dataset(variables, coordinates))
    missing = dataset.missing_samples(found)
    if plan is None:
        missing += _missing_by_index(samples, len(missing))
    attributes = _attributes(source, table, samples, notes, faults)
    if plan is not None and not is_imported(source.description or {}):
        attributes["planned"] = len(plan.points)
    return found.assign_attrs(with_sentences(attributes, missing=missing))


def _plan(source: Source) -> Optional[PlanFit]:
    if source.description is None:
        source.notes.append(
            Message(
                "the log of the survey is not here: it is not known whether the data are "
                "SIMULATED, nor what was planned, so missing rows at the edges cannot be detected"
            )
        )
        return None
    try:
        return PlanFit(source.description)
    except InvalidValueError as error:
        source.faults.append(Damage(unknown_plan(error.message)))
        return None


def _check_readable(source: Source, table: TraceTable) -> None:
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


def _unknown_times(imported: Mapping[str, Any]) -> Set[str]:
    """Return the times that the traces of an import have because they must have some."""
    if not imported:
        return set()
    # Of a sample one time at most is known, and none of its sweep.
    of_sweep = {"sweep_started", "sweep_ended"}
    return of_sweep if imported.get(TIMES_KNOWN) is True else {*of_sweep, dataset.TIMESTAMP}


def _quality(
    table: TraceTable, cells: int, faults: List[Damage], placed: Mapping[int, Sample]
) -> np.ndarray:
    """Return the flags of each cell of the grid."""
    found = np.full(cells, int(Quality.MISSING), np.uint8)
    for fault in faults:
        cell = None if fault.index is None else table.cell_of(fault.index)
        if cell is not None:
            found[cell] = int(Quality.DAMAGED)
    for cell, sample in placed.items():
        flags = Quality.REMARKED if sample["quality"] else Quality.GOOD
        if not np.isfinite(sample["antennae_height_m"]):
            flags |= Quality.NO_HEIGHT
        found[cell] = int(flags)
    return found


def _missing_by_index(samples: List[Sample], placed: int) -> List[Message]:
    """Return the samples that are missing by their index but have no place in the grid.

    Args:
        samples: Those of a survey without a plan.
        placed: Number of missing samples that have one.
    """
    indices = {sample.index for sample in samples}
    absent = sorted(set(range(max(indices, default=-1) + 1)) - indices)
    if len(absent) <= placed:
        return []
    return [
        Message(
            "missing: {count} samples at unknown positions, because indices {first} to {last} "
            "of the plan have gaps and the log of the survey is not here",
            count=len(absent) - placed,
            first=absent[0],
            last=absent[-1],
        )
    ]


def _attributes(
    source: Source,
    table: TraceTable,
    samples: List[Sample],
    notes: List[Message],
    faults: List[Damage],
) -> Dict[str, Any]:
    described = source.description or {}
    imported = import_of(described)
    notes += _texts(imported.get(NOTES))
    attributes: Dict[str, Any] = {
        # What people add to a survey may have been changed since.
        **{
            name: one
            for name, one in imported_attributes(imported).items()
            if name not in OF_PEOPLE
        },
        "format": dataset.FORMAT,
        "source": source.name,
        "survey_id": table.survey_id,
        **{word: str(described[word]) for word in RECORDED if described.get(word)},
        "stored": len(samples),
        **survey_attributes(described, samples, notes),
    }
    attributes = with_sentences(
        attributes,
        missing=[],
        faults=[fault.message for fault in faults],
        doubts=survey_doubts(described, list(table.samples.values()), len(faults)),
        notes=notes,
    )
    decisions = _texts(imported.get(DECISIONS))
    if decisions:
        attributes = with_sentences(attributes, decisions=decisions)
    if described:
        if "simulated" in described or not is_imported(described):
            attributes["simulated"] = int(bool(described.get("simulated")))
        attributes["survey_json"] = json.dumps(described)
    return attributes


def _texts(found: Any) -> List[Message]:
    return [verbatim(str(one)) for one in (found if isinstance(found, list) else [])]
