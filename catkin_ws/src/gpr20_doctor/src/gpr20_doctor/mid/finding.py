"""The result of one check."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
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
        restart: The service to restart after that, empty for the robot's here; None: none.
    """

    check: str
    level: Level
    text: Message
    remedy: Optional[Message] = None
    restart: Optional[str] = None

    @classmethod
    def of(
        cls,
        check: str,
        text: Message,
        fault: Optional[Fault] = None,
        mild: bool = False,
        advice: Optional[Message] = None,
        restart: Optional[str] = None,
    ) -> Finding:
        """Return the finding of a sentence: good, unless it reports a fault.

        That says level and remedy; `mild` makes it a warning, `advice` says more than its remedy.
        """
        if fault is None:
            return cls(check, Level.OK, text)
        found = text.with_fault(fault)
        known = cls.of_fault(check, found.as_warning() if mild else found)
        return replace(known, remedy=advice or known.remedy, restart=restart)

    @classmethod
    def of_fault(cls, check: str, text: Message) -> Finding:
        """Return the finding of a sentence that reports a fault: that says level and remedy."""
        cause = text.cause
        assert cause is not None
        return cls(check, Level[cause.severity.name], text, cause.remedy)


@dataclass(frozen=True)
class Unknown:
    """Takes the place of a fact that could not be found out.

    Attributes:
        reason: Why.
    """

    reason: Message


NOT_ASKED = Message("it was not looked for")
BY_HAND = Message("Look by hand: docs/doctor.md says how.")
ASK = Message("Run the doctor without --quick, or touch CHECK ALL on ROBOT.")


def not_known(check: str, subject: Message, fact: object, remedy: Message = BY_HAND) -> Finding:
    """Return that something is not known, and why.

    Args:
        check: Name of the check.
        subject: What is not known, in the middle of a sentence.
        fact: An `Unknown`, or anything else if it was not looked for.
        remedy: What to do.
    """
    reason = fact.reason if isinstance(fact, Unknown) else NOT_ASKED
    text = Message("Not known: {subject} ({reason}).", subject=subject, reason=reason)
    return Finding(check, Level.UNKNOWN, text, remedy if isinstance(fact, Unknown) else ASK)
