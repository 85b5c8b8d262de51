"""The report of a survey beside its traces: coverage, repeat measurements, analyzers."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from datetime import datetime, timezone
from typing import Any, Dict, List

from gpr20_common.message import Message, verbatim
from gpr20_main_control.errors import SurveyError
from gpr20_main_control.mid.analyzer_record import ANALYZERS, AnalyzerRecord
from gpr20_main_control.mid.repeat_measurement import RepeatMeasurement
from gpr20_survey.plan.coverage import Coverage, SampleState

COVERAGE_LETTERS = {
    SampleState.NOT_VISITED: "-",
    SampleState.MEASURED: "m",
    SampleState.REMEASURED: "r",
    SampleState.FAILED: "f",
}
# The report is bounded, however often an instrument fails; each trace has its own remarks.
MAX_WARNINGS = 1000


class SurveyReport:
    """Collects the entry `report` of survey.json."""

    def __init__(
        self, coverage: Coverage, analyzers: AnalyzerRecord, former_json: str = ""
    ) -> None:
        """Begin, or continue, a report.

        Args:
            coverage: The state of each planned sample.
            analyzers: With which analyzers it is measured.
            former_json: The report of the survey before it was resumed; empty if none exists.

        Raises:
            SurveyError: The former report cannot be read.
        """
        self.coverage = coverage
        self._analyzers = analyzers
        self._controls = _controls_of(former_json, coverage.planned)
        self._warnings = _warnings_of(former_json)
        for control in self._controls:
            coverage.note_remeasured(control["index"])

    def note_repeat(self, repeat: RepeatMeasurement, time_us: int) -> None:
        """Note that a stored point was measured again, and its difference from the trace."""
        self._controls.append(
            {
                "index": repeat.index,
                "time": _iso_time(time_us),
                "difference_db": _finite_or_none(repeat.difference_db),
                "height_difference_m": _finite_or_none(repeat.height_difference_m),
            }
        )
        self.coverage.note_remeasured(repeat.index)

    def note_warning(self, warning: Message, time_us: int) -> None:
        """Note a warning about the recording."""
        if len(self._warnings) >= MAX_WARNINGS:
            return
        self._warnings.append(
            {
                "time": _iso_time(time_us),
                "warning": str(warning),
                "warning_message": _record_of(warning),
            }
        )

    def to_json(self) -> str:
        """Return the report as it is stored in survey.json.

        `coverage` has one letter per planned sample, in the order of the plan: m measured,
        r measured again, f failed, - not visited. Sentences are stored twice: as English text,
        and as template and values for clients that translate them.
        """
        verdict = self.coverage.verdict().message
        reasons = sorted(self.coverage.reasons.items())
        return json.dumps(
            {
                "verdict": str(verdict),
                "verdict_message": _record_of(verdict),
                "coverage": "".join(COVERAGE_LETTERS[state] for state in self.coverage.states),
                "failed": [
                    {"index": index, "reason": str(reason), "reason_message": _record_of(reason)}
                    for index, reason in reasons
                ],
                "controls": self._controls,
                "warnings": self._warnings,
                ANALYZERS: [asdict(one) for one in self._analyzers.used],
            }
        )


def _controls_of(former_json: str, planned: int) -> List[Dict[str, Any]]:
    if not former_json:
        return []
    try:
        controls = json.loads(former_json)["controls"]
        controls = [{**control, "index": int(control["index"])} for control in controls]
        if not all(0 <= control["index"] < planned for control in controls):
            raise ValueError("a repeat measurement is not of a planned sample")
        return controls
    except (ValueError, TypeError, KeyError) as error:
        raise SurveyError(
            Message("the report in survey.json cannot be read", details=repr(error))
        ) from error


def _warnings_of(former_json: str) -> List[Dict[str, Any]]:
    # Reports of earlier versions have none.
    former = json.loads(former_json).get("warnings", []) if former_json else []
    if not isinstance(former, list):
        raise SurveyError(
            Message("the report in survey.json cannot be read", details="warnings: no list")
        )
    return former


def _iso_time(time_us: int) -> str:
    return datetime.fromtimestamp(time_us / 1e6, tz=timezone.utc).isoformat()


def _record_of(message: Message) -> Any:
    record = json.loads(message.to_json())
    try:
        json.dumps(record, allow_nan=False)
    except ValueError:
        # The storage refuses a report with NaN or infinity, which strict JSON does not have.
        return json.loads(verbatim(str(message)).to_json())
    return record


def _finite_or_none(value: float) -> Any:
    return value if math.isfinite(value) else None
