"""Moments as whole microseconds since 1970 in UTC, and as texts."""

from __future__ import annotations

import contextlib
import datetime
import re

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim

US_PER_S = 1_000_000
NS_PER_US = 1_000
NS_PER_S = 1_000_000_000

# A computer without a clock battery starts in 1970: such a time cannot be right.
EARLIEST_US = 1_577_836_800 * US_PER_S  # 2020-01-01
LATEST_US = (1 << 32) * US_PER_S  # a ROS time ends in 2106

_DATED = re.compile(r"(?P<year>\d{4})-(?P<month>\d\d)-(?P<day>\d\d)[T ](?P<time>\d\d:.*)")
_US = datetime.timedelta(microseconds=1)
_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)


def is_plausible(time_us: int) -> bool:
    """Return whether a moment [us since 1970] may be right."""
    return EARLIEST_US <= time_us < LATEST_US


def iso_text(time_us: int) -> str:
    """Return a moment [us since 1970] as ISO 8601 text ending in +00:00.

    That end, unlike Z, is read by `datetime.fromisoformat` of every Python 3.
    """
    moment = _EPOCH + datetime.timedelta(microseconds=time_us)
    return moment.isoformat(timespec="microseconds")


def moment_text(text: str) -> Message:
    """Return a moment that is written as in ISO 8601 as people of a language write it."""
    found = _DATED.fullmatch(re.sub(r"(\.\d+)?(Z|\+00:00)$", " UTC", text))
    return Message("{year}-{month}-{day} {time}", **found.groupdict()) if found else verbatim(text)


def parse_iso(text: str) -> int:
    """Return the moment [us since 1970] of a text that `iso_text` wrote.

    Raises:
        InvalidValueError: The text is anything else.
    """
    with contextlib.suppress(ValueError, TypeError):  # the latter without its end
        time_us = (datetime.datetime.fromisoformat(text) - _EPOCH) // _US
        if time_us >= 0 and iso_text(time_us) == text:
            return time_us
    raise InvalidValueError(
        Message(
            "{text} is not a time such as {example}",
            text=repr(text[:64]),
            example=iso_text(EARLIEST_US),
        )
    )
