"""What the values of a trace must be, beyond their types."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable, NoReturn

from gpr20_common.message import Fault, Message
from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import utc_time

_SHOWN = 64


@dataclass(frozen=True)
class Rule:
    """A rule for the values of a field.

    Attributes:
        holds: Returns whether a value is allowed.
        allowed: What is allowed, for people.
        fault: What a trace with another value reports.
    """

    holds: Callable[[Any], bool]
    allowed: Message
    fault: Fault = faults.TRACE_NOT_ALLOWED


def between(lower: float, upper: float, fault: Fault = faults.TRACE_NOT_ALLOWED) -> Rule:
    """Return the rule of a number."""
    # NaN fails every comparison; a negative zero is the same as zero in no stored form.
    return Rule(
        lambda value: lower <= value <= upper and (value != lower or str(value) != "-0.0"),
        Message("between {lower} and {upper}", lower=f"{lower:.12g}", upper=f"{upper:.12g}"),
        fault,
    )


def printable(most: int, fault: Fault = faults.TRACE_NOT_ALLOWED) -> Rule:
    """Return the rule of a text of so many printable characters."""
    allowed = Message("printable and have at most {most} characters", most=most)
    return Rule(lambda value: len(value) <= most and value.isprintable(), allowed, fault)


FINITE = Rule(math.isfinite, Message("finite"), faults.SENSOR_NOT_FINITE)
PLAUSIBLE = Rule(
    utc_time.is_plausible,
    Message(
        "between {earliest} and {latest}: set the computer's clock",
        earliest=utc_time.iso_text(utc_time.EARLIEST_US),
        latest=utc_time.iso_text(utc_time.LATEST_US),
    ),
    faults.CLOCK_WRONG,
)


def refuse(reason: Message, fault: Fault = faults.TRACE_NOT_ALLOWED) -> NoReturn:
    """Raise the error of a trace that is not allowed.

    Raises:
        TraceRefusedError: Always.
    """
    raise TraceRefusedError(Message("the trace is refused: {reason}", reason=reason), fault=fault)


def refuse_value(
    place: str, value: Any, allowed: Message, fault: Fault = faults.TRACE_NOT_ALLOWED
) -> NoReturn:
    """Raise the error of a value that is not allowed.

    Raises:
        TraceRefusedError: Always.
    """
    refuse(
        Message(
            "{place} is {value}; it must be {allowed}",
            place=place,
            value=shortened(value),
            allowed=allowed,
        ),
        fault,
    )


def shortened(value: Any) -> str:
    """Return a value cut to what a message can hold; a text is in quotes."""
    text = str(value)
    text = text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
    return repr(text) if isinstance(value, str) else text
