"""What the storage answers for a survey of these tests that was cut off."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
from survey_examples import AXES, PARAMETERS
from trace_examples import make_trace

from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace.sweep import AnalyzerSettings

SURVEY_ID = "5ec1a5d2-0000-4000-8000-000000000000"


def stored_trace(index, **changes):
    """Return a trace like the first sweep of the fake analyzer."""
    fields = dict(
        s21_real=np.ones(5),
        s21_imag=np.full(5, 1.0e4),
        analyzer=AnalyzerSettings(),
        survey_id=SURVEY_ID,
        x_coord_mm=0.0,
        y_coord_mm=0.0,
        z_coord_deg=0.0,
        antennae_height_m=0.2,
        zeros=(),
    )
    return make_trace(index, **{**fields, **changes})


def recorded_axes(**changes):
    """Return the parameters of the axes as a survey keeps them, changed."""
    return {axis_id.value: {**asdict(one), **changes} for axis_id, one in AXES.items()}


def reopened_survey(stored=(0, 1), report="", folder="/data/survey", **changes):
    """Return a survey of which these traces are stored, with some of its metadata changed."""
    metadata = {
        "simulated": True,
        "parameters": asdict(PARAMETERS),
        "axes": recorded_axes(),
        **changes,
    }
    recent = tuple(stored_trace(index) for index in sorted(stored)[-8:])
    return ReopenedSurvey(
        SURVEY_ID, folder, json.dumps(metadata), report, tuple(sorted(stored)), recent
    )
