"""A finding for what could not be found out."""

from __future__ import annotations

from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding, Level, Unknown

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
    return Finding(
        check,
        Level.UNKNOWN,
        Message("Not known: {subject} ({reason}).", subject=subject, reason=reason),
        remedy if isinstance(fact, Unknown) else ASK,
    )
