"""Which planned samples of a survey are stored, and whether they lie where they should."""

from __future__ import annotations

from typing import Any, Dict, List

from gpr20_analysis.errors import AnalysisError
from gpr20_common.errors import InvalidValueError
from gpr20_survey.plan.recorded_plan import recorded_plan
from gpr20_survey.plan.survey_plan import SurveyPoint, survey_points
from gpr20_survey.trace.trace import Trace


class Plan:
    """The samples that a survey was to take, worked out from its survey.json."""

    def __init__(self, description: Dict[str, Any]) -> None:
        """Work out the plan.

        Raises:
            AnalysisError: Parameters or axes are missing or not allowed.
        """
        try:
            self._parameters, self._travel = recorded_plan(description)
        except InvalidValueError as error:
            raise AnalysisError(
                f"what was planned cannot be told, survey.json is not whole: {error}"
            ) from error
        self.points: List[SurveyPoint] = survey_points(self._parameters, self._travel)

    def misplaced(self, trace: Trace) -> List[str]:
        """Return how a trace is not what was planned for its index."""
        if trace.index >= len(self.points):
            return [f"trace {trace.index} was not planned, the plan has {len(self.points)}"]
        point = self.points[trace.index]
        found = []
        for name, own, planned, travel in (
            ("x", trace.x_coord_mm, point.x_mm, self._travel.x),
            ("y", trace.y_coord_mm, point.y_mm, self._travel.y),
            ("z", trace.z_coord_deg, point.z_deg, self._travel.z),
        ):
            # Both are whole motor steps: half a step apart is another place.
            if abs(own - planned) > travel.step / 2:
                found.append(
                    f"trace {trace.index} was taken at {name} {own:g}, planned was {planned:g}"
                )
        if len(trace.frequency_hz) != self._parameters.frequency_points:
            found.append(
                f"trace {trace.index} has {len(trace.frequency_hz)} points, planned were "
                f"{self._parameters.frequency_points}"
            )
        return found
