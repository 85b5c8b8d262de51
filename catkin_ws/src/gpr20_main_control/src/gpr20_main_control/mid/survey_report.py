"""What is kept of a survey beside its traces: coverage and control measurements."""

from __future__ import annotations

import json
import math
from datetime import datetime, timezone
from typing import Any, Dict, List

from gpr20_main_control.errors import SurveyError
from gpr20_main_control.mid.repeat_measurement import RepeatMeasurement
from gpr20_survey.plan.coverage import Coverage, SampleState

COVERAGE_LETTERS = {
    SampleState.NOT_VISITED: "-",
    SampleState.MEASURED: "m",
    SampleState.REMEASURED: "r",
    SampleState.FAILED: "f",
}


class SurveyReport:
    """Collects what survey.json says of a survey under `report`."""

    def __init__(self, coverage: Coverage, former_json: str = "") -> None:
        """Begin, or continue, a report.

        Args:
            coverage: The state of each planned sample.
            former_json: The report of the survey before it was resumed; empty if there is none.

        Raises:
            SurveyError: The former report is not one.
        """
        self.coverage = coverage
        self._controls = _controls_of(former_json, coverage.planned)
        for control in self._controls:
            coverage.note_remeasured(control["index"])

    def note_repeat(self, repeat: RepeatMeasurement, time_us: int) -> None:
        """Note that a stored point was measured again, and how far it was from the trace."""
        self._controls.append(
            {
                "index": repeat.index,
                "time": datetime.fromtimestamp(time_us / 1e6, tz=timezone.utc).isoformat(),
                "difference_db": _finite_or_none(repeat.difference_db),
                "height_difference_m": _finite_or_none(repeat.height_difference_m),
            }
        )
        self.coverage.note_remeasured(repeat.index)

    def to_json(self) -> str:
        """Return the report as survey.json keeps it.

        `coverage` has one letter per planned sample, in the order of the plan: m measured,
        r measured again, f failed, - not visited.
        """
        reasons = self.coverage.reasons
        return json.dumps(
            {
                "verdict": self.coverage.verdict().text,
                "coverage": "".join(COVERAGE_LETTERS[state] for state in self.coverage.states),
                "failed": [{"index": index, "reason": reasons[index]} for index in sorted(reasons)],
                "controls": self._controls,
            }
        )


def _controls_of(former_json: str, planned: int) -> List[Dict[str, Any]]:
    if not former_json:
        return []
    try:
        controls = json.loads(former_json)["controls"]
        controls = [{**control, "index": int(control["index"])} for control in controls]
        if not all(0 <= control["index"] < planned for control in controls):
            raise ValueError("a control measurement is not of one of the planned samples")
        return controls
    except (ValueError, TypeError, KeyError) as error:
        raise SurveyError(f"the survey's former report cannot be read: {error!r}") from error


def _finite_or_none(value: float) -> Any:
    return value if math.isfinite(value) else None
