"""The daily check on SERVICE: which part is next, and what came back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.results.daily_check import Part
from gpr20_user_interface.mid.service_events import CheckStepTaken

PARTS = tuple(Part)


@dataclass(frozen=True)
class DailyCheckState:
    """Where the daily check is.

    Attributes:
        part: What is to be measured next, or is measured now; None: no check is in progress.
        answer: The verdict, or why the last step failed; None: there is neither.
        measuring: Whether a step is in progress.
    """

    part: Optional[Part] = None
    answer: Optional[CheckStepTaken] = None
    measuring: bool = False

    def after(self, answer: CheckStepTaken) -> DailyCheckState:
        """Return where the check is after the answer to a step."""
        if not answer.success:
            # A step that failed is repeated, unless the robot has forgotten those before it.
            forgotten = answer.message.fault_code == CHECK_ORDER.code
            return DailyCheckState(None if forgotten else self.part, answer)
        if self.part is None or self.part is PARTS[-1]:
            return DailyCheckState(None, answer)
        return DailyCheckState(PARTS[PARTS.index(self.part) + 1])
