"""Times as people say them: never with seconds, which change too fast to be read."""

from __future__ import annotations

import math

from gpr20_common.message import Message

MINUTES_PER_HOUR = 60
HOURS_PER_DAY = 24


def duration(time_s: float) -> Message:
    """Return a time [s] in words, such as `18 min`, `1 h 5 min` or `2 d 3 h`.

    It is rounded up: nothing that is left is shown as zero.
    """
    if time_s < 60.0:
        return Message("less than 1 min")
    minutes = math.ceil(time_s / 60.0)
    if minutes < MINUTES_PER_HOUR:
        return Message("{minutes} min", minutes=minutes)
    hours, minutes = divmod(minutes, MINUTES_PER_HOUR)
    if hours < HOURS_PER_DAY:
        return Message("{hours} h {minutes} min", hours=hours, minutes=minutes)
    days, hours = divmod(math.ceil(hours + minutes / MINUTES_PER_HOUR), HOURS_PER_DAY)
    return Message("{days} d {hours} h", days=days, hours=hours)


def time_left(time_s: float) -> Message:
    """Return how long [s] something still takes, in words."""
    return Message("{time} left", time=duration(time_s))
