"""Small surveys on the disk, written by the storage itself, without ROS."""

from __future__ import annotations

import json
import random
import shutil
import struct
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any, Callable, Dict, Mapping, Optional

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_survey.files.durable_files import ensure_folders
from gpr20_survey.folder.annotating import Fact, add_to_survey
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.markers import Marker, new_marker, removed_marker
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.recording.survey_topics import (
    TEXT_DEFINITION,
    TEXT_MD5SUM,
    TEXT_TYPE,
    SurveyTopics,
)
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_json import CHECKSUM
from gpr20_vna_processing.mid.data_processing import DataProcessing
from gpr20_vna_processing.mid.processing_records import Limits, Storage

SURVEY = "0f8fad5b-d9cb-469f-a165-70867728950e"
STARTED_US = 1_790_000_000_123_456
NOW_NS = 1_790_000_100_000_000_001
TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))
SURVEY_PARAMETERS = SurveyParameters(
    "127.0.0.1", 6e8, 6e9, 5, x_start_mm=10.0, x_stop_mm=20.0, x_points=3,
    y_start_mm=10.0, y_stop_mm=20.0, y_points=3,
)  # fmt: skip
PARAMETERS = asdict(SURVEY_PARAMETERS)
POINTS = survey_points(SURVEY_PARAMETERS, TRAVEL)
AXES = {
    name: {"min_coord": one.lower, "max_coord": one.upper, "step_size": one.step}
    for name, one in zip("xyz", (TRAVEL.x, TRAVEL.y, TRAVEL.z))
}

MESSAGES = Path(__file__).resolve().parents[3] / "gpr20_msgs" / "msg"
TRACE_DEFINITION = "\n".join(
    (
        *((MESSAGES / "Trace.msg").read_text(), "=" * 80, "MSG: std_msgs/Header"),
        *("uint32 seq\ntime stamp\nstring frame_id\n", "=" * 80, "MSG: gpr20_msgs/AuxValue"),
        (MESSAGES / "AuxValue.msg").read_text(),
    )
)


def planned_trace(index: int, **changes: Any) -> Trace:
    """Return the trace of a planned point, with some fields changed."""
    noise = np.random.default_rng(index)
    point = POINTS[index]
    fields = {
        "format": "gpr20-trace/1",
        "survey_id": SURVEY,
        "sample_id": f"sample-{index}",
        "index": index,
        "timestamp_us": STARTED_US + 10**6 * (index + 2),
        "x_coord_mm": point.x_mm,
        "y_coord_mm": point.y_mm,
        "z_coord_deg": point.z_deg,
        "antennae_height_m": 0.1 + 0.2,
        "frequency_hz": np.linspace(6e8, 6e9, 5),
        "s21_real": noise.standard_normal(5),
        "s21_imag": noise.standard_normal(5),
        "sweep_started_us": STARTED_US + 1,
        "sweep_ended_us": STARTED_US + 1_000_001,
        "quality": (),
        "analyzer": AnalyzerSettings(1000.0, 4, "HIGH"),
    }
    return Trace(**{**fields, **changes})


def _status(text: str, time_ns: int) -> RecordedMessage:
    content = text.encode()
    data = struct.pack("<I", len(content)) + content
    return RecordedMessage(
        "/control_status", TEXT_TYPE, TEXT_MD5SUM, TEXT_DEFINITION, data, time_ns, True
    )


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
    processing = DataProcessing(
        Storage(
            data=data / "data",
            check_data=lambda: ensure_folders(data / "data"),
            open_recordings=open_recordings,
            topics=SurveyTopics(TRACE_DEFINITION),
            free_bytes=lambda _: 10**12,
            now_ns=lambda: NOW_NS,
            clock=Clock(),
            revision="1.2.3",
            end_status=lambda end: _status(str(end.message), end.time_ns),
        ),
        Limits(timeout_s=10.0, period_s=0.05),
        on_opened=lambda _: None,
        on_stored=lambda _: None,
        on_logged=lambda _: None,
    )
    processing.start()
    metadata = {"planned_traces": len(POINTS), "parameters": PARAMETERS, "axes": AXES, **more}
    folder = processing.open_survey(SURVEY, STARTED_US, json.dumps(metadata), 1000)
    for index in range(stored):
        if recorded:
            processing.record(_status(f"measuring trace {index}", NOW_NS + index))
        processing.store(planned_trace(index, **misplaced.get(index, {})))
    at_end(processing)
    if outcome is None:
        folder = Path(shutil.copytree(str(folder), str(data / folder.name)))
    elif outcome != INTERRUPTED:  # as the shut down below does
        processing.close_survey(SURVEY, outcome)
    processing.shut_down()
    return folder


def add_marker(folder: Path, marker: Marker, now: str) -> None:
    """Add a marker to a survey that nobody writes."""
    _add(folder, Kind.MARKER, lambda before: new_marker(before, marker, now), now)


def remove_marker(folder: Path, marker: Marker, author: str, now: str) -> None:
    """Remove a marker of a survey that nobody writes."""
    identity = marker.marker_id
    _add(folder, Kind.MARKER_REMOVED, lambda one: removed_marker(one, identity, author, now), now)


def _add(folder: Path, kind: Kind, values_of: Callable[[Dict[str, Any]], Any], now: str) -> None:
    def change(description: Dict[str, Any]) -> Optional[Fact]:
        values = values_of(description)
        return None if values is None else Fact(kind, values)

    add_to_survey(folder, change, now)


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


def flipped(content: bytes, chance: random.Random) -> bytes:
    """Return a content with one byte changed, in any way."""
    at = chance.randrange(len(content))
    other = content[at] ^ chance.randrange(1, 256)
    return content[:at] + bytes([other]) + content[at + 1 :]


def write_trace_file(path: Path, values: Mapping[str, Any]) -> None:
    """Write a trace's file as a version without checksums wrote it."""
    without: Dict[str, Any] = {key: one for key, one in values.items() if key != CHECKSUM}
    path.write_text(json.dumps(without) + "\n")
