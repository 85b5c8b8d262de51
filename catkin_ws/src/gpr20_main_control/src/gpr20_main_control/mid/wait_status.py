"""Showing what a survey waits for when an answer takes long."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass
from typing import Callable, Iterator

from gpr20_common.message import Message
from gpr20_main_control.mid.interruption import Interruption
from gpr20_main_control.mid.survey_status import SurveyStatus

# A wait is shown when it takes this much longer than expected [s].
LATE_S = 1.5

Check = Callable[[], None]


@dataclass(frozen=True)
class ExpectedWait:
    """What is waited for, and how long that usually takes.

    Attributes:
        part: The part of the robot.
        action: What it does.
        expected_s: How long that usually takes [s].
        limit_s: When the wait ends in any case [s].
    """

    part: Message
    action: Message
    expected_s: float
    limit_s: float


class WaitStatus:
    """Shows in the status which part of the robot takes longer than expected."""

    def __init__(self, status: SurveyStatus, interruption: Interruption) -> None:
        self._status = status
        self._interruption = interruption

    @contextlib.contextmanager
    def shown(self, wait: ExpectedWait) -> Iterator[Check]:
        """Yield a check to call repeatedly during a wait; an interruption ends the wait."""
        with self.shown_beside(wait, self._interruption.check) as check:
            yield check

    @contextlib.contextmanager
    def shown_beside(self, wait: ExpectedWait, check: Check) -> Iterator[Check]:
        """Yield a check to call repeatedly during a wait.

        Args:
            wait: What is waited for.
            check: Called by the yielded one; an error that it raises ends the wait.
        """
        clock = self._interruption.clock
        late_s = clock.now_s() + wait.expected_s + LATE_S
        # For people: by the clock on the wall of the robot.
        until = time.strftime("%H:%M:%S", time.localtime(time.time() + wait.limit_s))
        shown = False

        def check_and_show() -> None:
            nonlocal shown
            check()
            if not shown and clock.now_s() > late_s:
                shown = True
                self._status.set_waiting(
                    Message(
                        "Waiting for {part}: {action}, until {time} at the latest",
                        part=wait.part,
                        action=wait.action,
                        time=until,
                    )
                )

        try:
            yield check_and_show
        finally:
            if shown:
                self._status.set_waiting(None)
