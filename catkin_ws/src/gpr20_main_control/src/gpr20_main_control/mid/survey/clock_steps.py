"""Whether the computer's clock was set during a survey."""

from __future__ import annotations

from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.trace.trace import Trace

# Less than this is how a time server usually corrects a clock [s].
LARGEST_CORRECTION_S = 2.0
# Less than this is the resolution of a clock [us].
ORDER_TOLERANCE_US = 10_000


class ClockSteps:
    """Compares the time of day with a clock that nobody sets, and traces with each other."""

    def __init__(
        self, clock: Clock, last: Optional[Trace], on_step: Callable[[Message], None]
    ) -> None:
        """Begin to compare, with the trace that was stored last, perhaps by another session."""
        self._clock = clock
        self._on_step = on_step
        self._last_us = 0 if last is None else last.timestamp_us
        self._offset_s = self._offset_now_s()

    def check(self) -> Optional[Message]:
        """Return how the clock was set since the last check; None if it was not."""
        offset_s = self._offset_now_s()
        step_s, self._offset_s = offset_s - self._offset_s, offset_s
        if step_s < -LARGEST_CORRECTION_S:
            # The order of the next trace is said herewith.
            self._last_us = 0
            return self._said(
                Message(
                    "the computer's clock was set back by {step_s:.0f} s during the survey; times "
                    "in the recording are out of order",
                    step_s=-step_s,
                )
            )
        if step_s > LARGEST_CORRECTION_S:
            return self._said(
                Message(
                    "the computer's clock was set forward by {step_s:.0f} s during the survey; "
                    "durations in the recording are too long",
                    step_s=step_s,
                )
            )
        return None

    def check_trace(self, timestamp_us: int) -> Optional[Message]:
        """Return what is wrong with the time of a new trace; None if nothing is."""
        message = self.check()
        behind_us, self._last_us = self._last_us - timestamp_us, timestamp_us
        if message is None and behind_us > ORDER_TOLERANCE_US:
            return self._said(
                Message(
                    "the computer's clock is {step_s:.1f} s behind the last stored trace; times "
                    "in the recording are out of order",
                    step_s=1.0e-6 * behind_us,
                )
            )
        return message

    def _said(self, message: Message) -> Message:
        message = message.with_fault(CLOCK_WRONG.as_warning())
        self._on_step(message)
        return message

    def _offset_now_s(self) -> float:
        return 1.0e-6 * self._clock.time_of_day_us() - self._clock.now_s()
