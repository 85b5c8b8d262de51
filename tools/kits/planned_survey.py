"""A survey with a whole plan, so that the offline verification can judge it."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.trace.trace import Trace

TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))
PARAMETERS = SurveyParameters(
    "127.0.0.1", 6e8, 6e9, 5, x_start_mm=10.0, x_stop_mm=20.0, x_points=3,
    y_start_mm=10.0, y_stop_mm=20.0, y_points=3, polarizations_deg=(0.0,),
)  # fmt: skip
POINTS = survey_points(PARAMETERS, TRAVEL)
AXES = {
    name: {"min_coord": one.lower, "max_coord": one.upper, "step_size": one.step}
    for name, one in zip("xyz", (TRAVEL.x, TRAVEL.y, TRAVEL.z))
}
METADATA = json.dumps(
    {
        "planned_traces": len(POINTS),
        "simulated": True,
        "parameters": asdict(PARAMETERS),
        "axes": AXES,
    }
)


def planned_trace(index: int, survey_id: str = SURVEY, **changes: Any) -> Trace:
    """Return the trace of a planned point, with some fields changed."""
    point = POINTS[index]
    fields = {
        "survey_id": survey_id,
        "timestamp_us": STARTED_US + 10**6 * (index + 2),
        "x_coord_mm": point.x_mm,
        "y_coord_mm": point.y_mm,
        "z_coord_deg": point.z_deg,
    }
    return make_trace(index, **{**fields, **changes})
