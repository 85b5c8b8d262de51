"""The result of one check."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Fault, Message


class Level(enum.IntEnum):
    """How a check ended; the higher, the worse."""

    OK = 0
    # Neither good nor bad: a check that is not needed, or what the next survey does by itself.
    NOTE = 1
    # Nothing could be found out, so it may be good or bad.
    UNKNOWN = 2
    WARNING = 3
    FAULT = 4

    @property
    def title(self) -> Message:
        """The level in one word."""
        return _TITLES[self]


_TITLES = (
    Message("GOOD"),
    Message("NOTE"),
    Message("UNKNOWN"),
    Message("WARNING"),
    Message("FAULT"),
)


@dataclass(frozen=True)
class Finding:
    """The result of a check.

    Attributes:
        check: Short name of the check, for programs.
        level: How it ended.
        text: What was found, in one sentence.
        remedy: What to do; None only if nothing is wrong.
    """

    check: str
    level: Level
    text: Message
    remedy: Optional[Message] = None

    @classmethod
    def of(
        cls,
        check: str,
        text: Message,
        fault: Optional[Fault] = None,
        mild: bool = False,
        advice: Optional[Message] = None,
    ) -> Finding:
        """Return the finding of a sentence: good, unless it reports a fault, or is given one.

        That says level and remedy; `mild` makes it a warning, `advice` says more than its remedy.
        """
        found = text if fault is None else text.with_fault(fault)
        found = found.as_warning() if mild else found
        cause = found.cause
        if cause is None:
            return cls(check, Level.OK, found)
        return cls(check, Level[cause.severity.name], found, advice or cause.remedy)
