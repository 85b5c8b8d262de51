"""Makes a survey of any size on the disk, as the storage would have written it, for benchmarks.

The storage's own writers make the files; only the waiting for the disk after every trace is left
out.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, Dict

import numpy as np

from gpr20_survey.folder import manifest, survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import START
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.recording.bag import make_bag
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

SURVEY_ID = "0f8fad5b-d9cb-469f-a165-70867728950e"
STARTED_US = 1_790_000_000_000_000
TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))
TRACE, STRING = "gpr20_msgs/msg/Trace", "std_msgs/msg/String"
TRACES_PER_COMMIT = 500
ENDING = ("ended", "outcome", "reason", "stored_traces")


def make(folder: Path, x_points: int, y_points: int, frequency_points: int = 501) -> int:
    """Write a survey of noise, which is the hardest to compress; return its number of traces.

    Args:
        folder: Made here; must not exist.
        x_points: Columns.
        y_points: Rows; each stop has two polarizations.
        frequency_points: Points of a sweep.
    """
    parameters = SurveyParameters(
        "127.0.0.1", 6e8, 6e9, frequency_points, x_start_mm=0.0, x_stop_mm=600.0,
        x_points=x_points, y_start_mm=0.0, y_stop_mm=600.0, y_points=y_points,
    )  # fmt: skip
    points = survey_points(parameters, TRAVEL)
    traces = folder / survey_folder.TRACES_FOLDER
    traces.mkdir(parents=True)
    description = _description(parameters, len(points))
    text = json.dumps(description)
    recording = McapFile(folder / survey_folder.MCAP_FILE)
    topics = SurveyTopics()
    recording.write(topics.metadata(text, STARTED_US * 1000))
    noise = np.random.default_rng(20)
    frequency_hz = np.linspace(6e8, 6e9, frequency_points)
    for point in points:
        moment_us = STARTED_US + 10**6 * (point.index + 1)
        real, imag = noise.standard_normal((2, frequency_points)) * 1e-3
        trace = Trace(
            frequency_hz, real, imag, moment_us - 500_000, moment_us - 1000, (), AnalyzerSettings(),
            SURVEY_ID, f"sample-{point.index}", point.index, moment_us,
            point.x_mm, point.y_mm, point.z_deg, 0.2,
        )  # fmt: skip
        (traces / survey_folder.trace_file_name(trace)).write_bytes(trace_files.encode(trace))
        recording.write_alone(topics.trace(trace, moment_us * 1000))
        if point.index % TRACES_PER_COMMIT == 0:
            recording.commit()
    recording.commit()
    recording.finish()
    log = SurveyLog(folder, [], whole=False)
    end = {key: description[key] for key in ENDING}
    plan = {key: value for key, value in description.items() if key not in ENDING}
    log.add(log.next(Kind.PLAN, {**START, **plan}, description["started"]))
    log.add(log.next(Kind.END, end, description["ended"]))
    log.write_description()
    ended = str(description["ended"])
    manifest.write_manifest(folder, SURVEY_ID, log.last, "benchmark", ended)
    make_bag(folder)
    return len(points)


def described(parameters: SurveyParameters, planned: int) -> Dict[str, Any]:
    """Return what is known of a survey before its first trace."""
    axes = {
        name: {"min_coord": one.lower, "max_coord": one.upper, "step_size": one.step}
        for name, one in zip("xyz", (TRAVEL.x, TRAVEL.y, TRAVEL.z))
    }
    return {
        "simulated": True, "planned_traces": planned, "parameters": asdict(parameters),
        "axes": axes,
    }  # fmt: skip


def _description(parameters: SurveyParameters, planned: int) -> Dict[str, Any]:
    return {
        "format": survey_metadata.FORMAT, "survey_id": SURVEY_ID,
        "started": "2026-09-21T14:13:20.000000+00:00", "ended": "2026-09-21T15:13:20.000000+00:00",
        "outcome": "finished", "reason": "", "stored_traces": planned,
        **described(parameters, planned),
    }  # fmt: skip
