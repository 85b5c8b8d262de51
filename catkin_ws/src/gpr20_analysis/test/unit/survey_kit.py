"""Small surveys on the disk, written by the storage itself, without ROS."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Callable, Dict, Mapping, Optional

import trace_examples
from storage_kit import NOW_NS, Kit, text_message
from trace_examples import AXES, STARTED_US, SURVEY, TRAVEL, make_trace

from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.folder.trace_files import sealed
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.data_processing import DataProcessing

SURVEY_PARAMETERS = replace(trace_examples.PARAMETERS, polarizations_deg=(0.0, 90.0))
PARAMETERS = asdict(SURVEY_PARAMETERS)
POINTS = survey_points(SURVEY_PARAMETERS, TRAVEL)


def planned_trace(index: int, **changes: Any) -> Trace:
    """Return the trace of a planned point without remarks, with some fields changed."""
    point = POINTS[index]
    place = {"x_coord_mm": point.x_mm, "y_coord_mm": point.y_mm, "z_coord_deg": point.z_deg}
    plain = {"timestamp_us": STARTED_US + 10**6 * (index + 2), "quality": (), "aux": ()}
    return make_trace(index, **{**place, **plain, "zeros": (), **changes})


def make_survey(
    data: Path,
    stored: int,
    outcome: Optional[str],
    misplaced: Mapping[int, Mapping[str, Any]] = MappingProxyType({}),
    recorded: bool = False,
    more: Mapping[str, Any] = MappingProxyType({}),
    at_end: Callable[[DataProcessing], Any] = lambda _: None,
) -> Path:
    """Store a survey and return its folder.

    Args:
        data: Where the folder is made.
        stored: How many of the planned traces are stored.
        outcome: How the survey ends; None leaves it as a kill would.
        misplaced: What some traces have other than planned.
        recorded: Whether the recordings hold messages of another topic too.
        more: More entries of survey.json.
        at_end: Called when the traces are stored, while the survey is open.
    """
    kit = Kit(data / "data")
    processing = kit.processing
    metadata = {"planned_traces": len(POINTS), "parameters": PARAMETERS, "axes": AXES, **more}
    folder = kit.open(metadata_json=json.dumps(metadata))
    for index in range(stored):
        if recorded:
            text = f"measuring trace {index}"
            processing.record(text_message("/control_status", text, NOW_NS + index, latching=True))
        processing.store(planned_trace(index, **misplaced.get(index, {})))
    at_end(processing)
    if outcome is None:
        folder = Path(shutil.copytree(str(folder), str(data / folder.name)))
    elif outcome != INTERRUPTED:  # as the shut down below does
        processing.close_survey(SURVEY, outcome)
    processing.shut_down()
    return folder


def describe_again(folder: Path, **changes: Any) -> None:
    """Let a survey's log say something else, as if it had been written so from the start."""
    found = recover(folder)
    description = {**found.description, **changes}
    records = [LogRecord.after(None, Kind.PLAN, description, description["started"])]
    for one in found.found.records[1:]:  # the manifest may name the number of the last one
        records.append(LogRecord.after(records[-1], Kind.AUDIT, {}, one.time))
    SurveyLog(folder, records, whole=False).write()


def contents(folder: Path) -> Dict[str, bytes]:
    """Return all files of a folder, by their name in it."""
    files = (one for one in folder.rglob("*") if one.is_file())
    return {one.relative_to(folder).as_posix(): one.read_bytes() for one in files}


def write_trace_file(path: Path, values: Mapping[str, Any]) -> None:
    """Write values as a trace's file with a right checksum."""
    without: Dict[str, Any] = {key: one for key, one in values.items() if key != "sha256"}
    path.write_bytes(sealed(json.dumps(without).encode()))
