"""What a test of the analyzer has found, as fields of the answer of test_analyzer, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Optional

from gpr20_common.message import Message
from gpr20_common.sent_message import message_fields, message_from, record_of


@dataclass(frozen=True)
class AnalyzerTest:
    """What a test of the analyzer has found, up to its first failure; None: it had none.

    The calibration is the name of a `CalibrationStatus`; another version of the software may know
    more of them.
    """

    address: str
    identity: str = ""
    calibration: str = ""
    points: int = 0
    sweep_duration_s: float = 0.0
    level_db: float = 0.0
    failure: Optional[Message] = None


def analyzer_test_fields(test: AnalyzerTest) -> Dict[str, Any]:
    found = dict(vars(test))
    failure = found.pop("failure")
    said = message_fields(failure or Message("The VNA works."))
    return {"success": failure is None, **said, **found}


def analyzer_test_of(answer: Any) -> AnalyzerTest:
    failure = None if answer.success else message_from(answer)
    return record_of(AnalyzerTest, answer, failure=failure)
