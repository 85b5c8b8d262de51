"""ROS messages of traces and surveys to the records of this package."""

from __future__ import annotations

from typing import Any

import numpy as np

from gpr20_msgs.msg import SurveyCoverage, SurveySummary, Trace
from gpr20_user_interface.mid.map_coverage import CoverageRuns
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.radar_model import RadarTrace
from gpr20_user_interface.mid.trace_events import (
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)


def radar_trace(message: Trace) -> RadarTrace:
    """Convert a trace; its numbers become single precision, enough for a picture."""
    s21 = np.empty(len(message.s21_real), np.complex64)
    s21.real = message.s21_real
    s21.imag = message.s21_imag[: len(s21)]
    return RadarTrace(
        survey_id=message.survey_id,
        index=message.index,
        x_mm=message.x_coord_mm,
        y_mm=message.y_coord_mm,
        z_deg=message.z_coord_deg,
        height_m=message.antennae_height_m,
        # Not in single precision: frequencies near 6 GHz would be 512 Hz apart.
        frequency_hz=np.array(message.frequency_hz, np.float64),
        s21=s21,
    )


def coverage_runs(message: SurveyCoverage) -> CoverageRuns:
    """Convert `survey_coverage`."""
    return CoverageRuns(
        survey_id=message.survey_id,
        planned=message.planned,
        starts=tuple(message.run_starts),
        states=tuple(bytearray(message.run_states)),
        failures=tuple(message.failures),
        verdict=message.verdict,
    )


def survey_described(message: Any) -> SurveyDescribed:
    """Convert `survey_metadata`."""
    return SurveyDescribed(message.data)


def survey_read(folder: str, response: Any) -> SurveyRead:
    """Convert the answer of `read_survey`."""
    return SurveyRead(folder, response.metadata_json, tuple(response.stored_indices))


def traces_read(first_index: int, response: Any) -> TracesRead:
    """Convert the answer of `read_traces`."""
    return TracesRead(
        survey=response.survey_id,
        first_index=first_index,
        traces=tuple(radar_trace(trace) for trace in response.traces),
        unreadable=tuple(response.unreadable),
    )


def surveys_listed(before: str, response: Any) -> SurveysListed:
    """Convert the answer of `list_surveys`."""
    surveys = tuple(_past_survey(one) for one in response.surveys)
    return SurveysListed(before, surveys, response.more)


def _past_survey(message: SurveySummary) -> PastSurvey:
    return PastSurvey(**{name: getattr(message, name) for name in message.__slots__})
