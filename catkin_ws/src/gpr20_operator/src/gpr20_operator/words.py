"""Numbers as people write them; times as they say them, without seconds, which flicker."""

from __future__ import annotations

import contextlib
import datetime
import math
import re
from typing import Iterable, Sequence, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, numeral, verbatim
from gpr20_survey.trace.utc_time import moment_text

# Not float() alone: it accepts digits of other scripts, underscores and words.
_NUMBER = re.compile(r"[-+]?([0-9]{1,20}([.,][0-9]{0,20})?|[.,][0-9]{1,20})([eE][-+]?[0-9]{1,3})?")
SHOWN_CHARACTERS = 64
STARTED, FOLDER = "%Y-%m-%dT%H:%M:%S", "%Y%m%dT%H%M%S"
HERTZ_PER_MEGAHERTZ = 1.0e6
# Of a whole number; far more than any parameter needs.
MAX_DIGITS = 18


def number_from_text(text: str) -> float:
    """Return the number of a text such as "12.5" or "12,5".

    Fields show numbers with a point in every language, as the VNA and the files have them.

    Raises:
        InvalidValueError: The text is not a number, or one beyond all numbers of a computer.
    """
    number = text.strip()
    value = math.nan
    if _NUMBER.fullmatch(number):
        value = float(number.replace(",", ".")) + 0.0  # no negative zero
    if not math.isfinite(value):
        raise InvalidValueError(Message("'{text}' is not a number", text=text[:SHOWN_CHARACTERS]))
    return value


def entered_number(text: str, form: str = ".12g") -> Message:
    """Return what is in a field as people read it; other text than a number as it is."""
    try:
        return numeral(number_from_text(text), form)
    except InvalidValueError:
        return verbatim(text)


def in_line(numbers: Sequence[Message]) -> Message:
    """Return numbers with what stands between them where a comma may be a decimal comma."""
    line = numbers[0] if numbers else verbatim("")
    for one in numbers[1:]:
        line = Message("{numbers}, {number}", numbers=line, number=one)
    return line


def hertz_from_megahertz(text: str) -> float:
    """Return the frequency [Hz] of a number of megahertz, to a thousandth.

    A product of floats alone would be off by a fraction of that for many inputs.

    Raises:
        InvalidValueError: The text is not a number.
    """
    return round(number_from_text(text) * HERTZ_PER_MEGAHERTZ, 3)


def megahertz_text(frequency_hz: float) -> str:
    """Return a frequency [Hz] as a number of megahertz."""
    return number_text(frequency_hz / HERTZ_PER_MEGAHERTZ)


def rotations_from_text(text: str) -> Tuple[float, ...]:
    """Return the rotations [deg] of a list, such as "0, 90".

    With semicolons between the rotations, as in "1,8; 90", a comma is a decimal comma.

    Raises:
        InvalidValueError: A part of the list is not a number.
    """
    separator = ";" if ";" in text else ","
    return tuple(number_from_text(part) for part in text.split(separator))


def rotations_text(rotations_deg: Iterable[float]) -> str:
    """Return rotations [deg] as a list with commas."""
    return ", ".join(map(number_text, rotations_deg))


def whole_from_text(text: str) -> int:
    """Return a whole number of 0 or more.

    Raises:
        InvalidValueError: The text is none.
    """
    digits = text.strip()
    # Not int() alone: it accepts digits of other scripts, underscores and signs, and refuses
    # thousands of digits and some of the blanks that strip() removes.
    if not (digits.isascii() and digits.isdigit() and len(digits) <= MAX_DIGITS):
        raise InvalidValueError(
            Message("'{text}' is not a whole number of 0 or more", text=text[:SHOWN_CHARACTERS])
        )
    return int(digits)


def number_text(value: float) -> str:
    """Return a number with up to twelve digits."""
    return f"{value:.12g}"


def duration(time_s: float) -> Message:
    """Return a time [s] in words, such as `18 min`, `1 h 5 min` or `2 d 3 h`.

    It is rounded up: nothing that is left is shown as zero.
    """
    if time_s < 60.0:
        return Message("less than 1 min")
    minutes = math.ceil(time_s / 60.0)
    if minutes < 60:
        return Message("{minutes} min", minutes=minutes)
    hours, minutes = divmod(minutes, 60)
    if hours < 24:
        return Message("{hours} h {minutes} min", hours=hours, minutes=minutes)
    days, hours = divmod(math.ceil(hours + minutes / 60), 24)
    return Message("{days} d {hours} h", days=days, hours=hours)


def time_left(time_s: float) -> Message:
    """Return how long [s] something still takes, in words."""
    return Message("{time} left", time=duration(time_s))


def size_text(width_mm: float, height_mm: float) -> Message:
    """Return the size of an area."""
    return Message("{width:g} x {height:g} mm", width=width_mm, height=height_mm)


def local_time(started: str, folder: str = "") -> Message:
    """Return when a survey started, as "2026-11-21 05:10", in the time of this computer.

    Args:
        started: ISO 8601, UTC; empty if it is not recorded.
        folder: Name of its folder, which begins with the start.
    """
    for text, pattern in ((started[:19], STARTED), (folder[:15], FOLDER)):
        with contextlib.suppress(ValueError):
            at = datetime.datetime.strptime(f"{text}+0000", f"{pattern}%z")
            return moment_text(at.astimezone().strftime("%Y-%m-%d %H:%M"))
    return verbatim(folder)
