"""Check of the times of a survey: what was measured later has later times.

Every contradiction can come from a clock that was set during the survey, so none of them is a
fault: the order of the recordings says what was measured when.
"""

from __future__ import annotations

from typing import Any, Dict, List, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import Trace

SHOWN = 5
"""Number of traces that are named."""


class TimeCheck:
    """Takes the traces in the order of a recording."""

    def __init__(self, description: Dict[str, Any]) -> None:
        self._started_us = _time_us(description.get("started"))
        self._ended_us = _time_us(description.get("ended"))
        self._previous: Optional[Trace] = None
        self._backward: List[Message] = []
        self._before: List[int] = []
        self._after: List[int] = []

    def note(self, trace: Trace) -> None:
        """Take the next trace."""
        before = self._previous
        if before is not None and trace.timestamp_us < before.timestamp_us:
            self._backward.append(
                Message(
                    "trace {index} of {time} was recorded after trace {other} of {other_time}",
                    index=trace.index,
                    time=utc_time.iso_text(trace.timestamp_us),
                    other=before.index,
                    other_time=utc_time.iso_text(before.timestamp_us),
                )
            )
        if trace.timestamp_us < trace.sweep_started_us:
            self._backward.append(
                Message(
                    "trace {index} of {time} has a sweep that started at {other_time}",
                    index=trace.index,
                    time=utc_time.iso_text(trace.timestamp_us),
                    other_time=utc_time.iso_text(trace.sweep_started_us),
                )
            )
        if self._started_us is not None and trace.sweep_started_us < self._started_us:
            self._before.append(trace.index)
        if self._ended_us is not None and trace.timestamp_us > self._ended_us:
            self._after.append(trace.index)
        self._previous = trace

    def notes(self) -> List[Message]:
        """Return what contradicts the order of time."""
        found: List[Message] = []
        started, ended = self._started_us, self._ended_us
        if started is not None and ended is not None and ended < started:
            found.append(
                Message(
                    "the survey ended at {ended}, before it started at {started}: the clock was "
                    "set back",
                    ended=utc_time.iso_text(ended),
                    started=utc_time.iso_text(started),
                )
            )
        for one in self._backward[:SHOWN]:
            found.append(
                Message(
                    "out of order: {sentence}: the clock was set, or the trace was added by a "
                    "repair",
                    sentence=one,
                )
            )
        if len(self._backward) > SHOWN:
            found.append(
                Message("{count} more are out of order", count=len(self._backward) - SHOWN)
            )
        if self._before and started is not None:
            found.append(
                Message(
                    "{count} traces are older than the start of the survey, {started}: {indices}",
                    count=len(self._before),
                    started=utc_time.iso_text(started),
                    indices=_listed(self._before),
                )
            )
        if self._after and ended is not None:
            found.append(
                Message(
                    "{count} traces are newer than the end of the survey, {ended}: {indices}",
                    count=len(self._after),
                    ended=utc_time.iso_text(ended),
                    indices=_listed(self._after),
                )
            )
        return found


def _time_us(text: Any) -> Optional[int]:
    try:
        return utc_time.parse_iso(text)
    except (TypeError, InvalidValueError):
        return None


def _listed(indices: List[int]) -> str:
    shown = ", ".join(map(str, indices[:SHOWN]))
    return shown if len(indices) <= SHOWN else f"{shown}, ..."
