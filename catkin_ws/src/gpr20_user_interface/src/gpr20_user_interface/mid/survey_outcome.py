"""How the terminal client ends: a status for the shell and a sentence."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from gpr20_common.message import Message


class ExitStatus(enum.IntEnum):
    """How the survey ended, as the status of the process."""

    FINISHED = 0
    REFUSED = 1
    FAILED = 3
    PAUSED = 4
    # What was followed was a replay: nothing was measured.
    REPLAY = 5
    STOPPED = 130


@dataclass(frozen=True)
class Outcome:
    """How it ended: a number for the shell and a sentence.

    Attributes:
        status: For the shell.
        message: What happened.
        other_analyzer: Identity of another analyzer with which the survey can be resumed; empty
            if there is nothing to accept.
    """

    status: ExitStatus
    message: Message
    other_analyzer: str = ""
