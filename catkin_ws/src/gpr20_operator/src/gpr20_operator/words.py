"""Times as people say them: never with seconds, which change too fast to be read."""

from __future__ import annotations

import math
import re
from decimal import Decimal

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message

# Not Decimal() or float() alone: they accept digits of other scripts, underscores and words.
_NUMBER = re.compile(r"[-+]?([0-9]{1,20}([.,][0-9]{0,20})?|[.,][0-9]{1,20})([eE][-+]?[0-9]{1,3})?")
SHOWN_CHARACTERS = 64


def decimal_from_text(text: str) -> Decimal:
    """Return the number of a text such as "12.5" or "12,5", exactly.

    Numbers are shown with a point in every language, as the VNA and the files have them.

    Raises:
        InvalidValueError: The text is not a number.
    """
    number = text.strip()
    if not _NUMBER.fullmatch(number):
        raise InvalidValueError(Message("'{text}' is not a number", text=text[:SHOWN_CHARACTERS]))
    return Decimal(number.replace(",", "."))


def number_from_text(text: str) -> float:
    """Return the number of a text such as "12.5" or "12,5".

    Raises:
        InvalidValueError: The text is not a number, or one beyond all numbers of a computer.
    """
    value = float(decimal_from_text(text))
    if not math.isfinite(value):
        raise InvalidValueError(Message("'{text}' is not a number", text=text[:SHOWN_CHARACTERS]))
    return value


def plain_text(value: Decimal) -> str:
    """Return a number without an exponent and without zeros at its end."""
    text = f"{value:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


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
