"""Progress in words."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gpr20_user_interface.mid.events import Progress


@dataclass(frozen=True)
class TimeParts:
    """A time in whole days, hours, minutes and seconds."""

    days: int
    hours: int
    minutes: int
    seconds: int


def time_parts(time_s: float) -> TimeParts:
    """Split a time [s], rounded up: nothing that remains is shown as zero."""
    minutes, seconds = divmod(max(0, math.ceil(time_s)), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    return TimeParts(days, hours, minutes, seconds)


def time_text(time_s: float) -> str:
    """Return a time [s] as `0d:0h:18m:48s`."""
    parts = time_parts(time_s)
    return f"{parts.days}d:{parts.hours}h:{parts.minutes}m:{parts.seconds}s"


def remaining_text(progress: Progress) -> str:
    """Return the remaining time and its basis: the plan, or the points taken so far."""
    basis = "plan" if progress.visited_points == 0 else "measured"
    return f"{time_text(progress.remaining_s)} remaining ({basis})"


def progress_line(progress: Progress) -> str:
    """Return one line with everything that `control_survey_data` says."""
    return (
        f"{progress.completion_percent:5.1f} %  {progress.visited_points}/{progress.total_points} "
        f"traces  {remaining_text(progress)}"
    )
