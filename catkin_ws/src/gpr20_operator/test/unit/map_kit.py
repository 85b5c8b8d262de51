"""Candidates and markers for the tests of MAP."""

import json
from dataclasses import asdict

import numpy as np
from candidate_examples import candidate, candidate_list
from view_kit import SURVEY

from gpr20_operator.jobs.pictures import StoredSurvey
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import Flag

MARKER = Marker(
    "0f8fad5b-d9cb-469f-a165-708677289501", 175.0, 70.0, 60.0, "raíz", "Ana",
    "2026-11-21T05:10:00.000000Z",
)  # fmt: skip
SURE = candidate(1, 125.0, 90.0, 85.0, 21.0)
DOUBTED = candidate(2, 125.0, 90.0, 140.0, 12.0, (Flag.EDGE,))


def focused(candidates=(SURE, DOUBTED), survey_id=SURVEY):
    x_mm, y_mm, depth_mm = np.arange(3.0), np.arange(2.0), np.arange(4.0)
    levels_db = np.zeros((4, 2, 3), np.float32)
    found = candidate_list(candidates, survey_id=survey_id)
    return FocusedImage(9, x_mm, y_mm, depth_mm, levels_db, found)


def marked(*markers):
    """Return what the storage answers of a survey with these markers."""
    return StoredSurvey(json.dumps({"markers": [asdict(one) for one in markers]}), ())
