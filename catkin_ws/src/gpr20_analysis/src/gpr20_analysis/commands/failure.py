"""What a command says when it cannot do what it was asked for."""

from __future__ import annotations

from typing import List

from gpr20_analysis import faults
from gpr20_analysis.errors import library_missing
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import ASKED_FOR, DISK_REFUSES, NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.faults import NOT_SIGNED

EXTRAS = {"distributed": "batch", "matplotlib": "plots", "segyio": "segy", "skrf": "touchstone"}
"""Optional libraries, and the extra of each."""
EXPECTED = (Gpr20Error, OSError, MemoryError, ModuleNotFoundError)
"""Errors whose message is sufficient; all others are program errors."""
TRACEBACK = "GPR20_TRACEBACK"
"""Environment variable: if set, a program error prints its traceback."""
STEP_IS_SAID = frozenset(
    one.code
    for one in (
        *(NOT_ALLOWED, ASKED_FOR, faults.INPUT, faults.STEPS, faults.TOO_LARGE),
        *(faults.NO_ROS, faults.ROBOT_RUNS, faults.PROGRAM, NOT_SIGNED),
    )
)
"""Codes whose remedy says in general what each of their sentences says exactly."""


def message_of(error: BaseException, command: str) -> Message:
    """Return what went wrong.

    Args:
        error: Ended the command.
        command: What was called, such as "gpr20 info x".
    """
    if isinstance(error, Gpr20Error):
        file = error.filename if isinstance(error, OSError) else None
        return (
            Message("{file}: {reason}", file=file, reason=error.message) if file else error.message
        )
    if isinstance(error, KeyboardInterrupt):
        return Message("interrupted; no partial output is left").with_fault(ASKED_FOR)
    if isinstance(error, ModuleNotFoundError):
        name = error.name or ""
        missing = library_missing(name, EXTRAS.get(name.split(".")[0], ""))
        return missing.with_fault(faults.STEPS)
    if isinstance(error, MemoryError):
        message = Message("not enough memory; use fewer samples", details=error)
        return message.with_fault(faults.TOO_LARGE)
    if isinstance(error, OSError):
        reason = os_reason(error)
        if error.filename:
            reason = Message("{file}: {reason}", file=error.filename, reason=reason)
        return reason if reason.cause else reason.with_fault(DISK_REFUSES)
    return Message(
        "program error {error}; please report it with the output of {command}",
        error=f"{type(error).__name__}: {error}",
        command=f"{TRACEBACK}=1 {command}",
    ).with_fault(faults.PROGRAM)


def first_steps(message: Message) -> List[Message]:
    """Return what to do first; nothing if the message says it, or if that is not known."""
    cause = message.cause
    if cause is None or cause.remedy is None or cause.code in STEP_IS_SAID:
        return []
    return [Message("First: {remedy}", remedy=cause.remedy)]
