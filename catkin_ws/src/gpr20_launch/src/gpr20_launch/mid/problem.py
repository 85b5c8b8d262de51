"""What the check of a robot's configuration finds, as data; its sentences are English."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Union

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Fault, Message, Severity
from gpr20_common.terminal_text import printable


@dataclass(frozen=True)
class Problem:
    """One mistake, or something doubtful, in the configuration of a robot.

    Attributes:
        message: All of it as one sentence, with its fault.
        file: The file; empty: a setting of the computer.
        key: The key in it, such as y/sensor_pin; empty: the whole file.
        value: Its value as Python shows it.
    """

    message: Message
    file: str = ""
    key: str = ""
    value: str = ""

    @property
    def refuses(self) -> bool:
        """Whether the robot must not be launched; otherwise it is doubtful."""
        return self.message.severity in (None, Severity.FAULT)

    def record(self) -> Dict[str, Any]:
        """Return the sentence as it travels, and the place beside it."""
        return {**self.message.record(), "file": self.file, "key": self.key, "value": self.value}


def problem(
    file: Union[Path, str],
    key: str,
    value: object,
    reason: object,
    allowed: object,
    doubtful: bool = False,
    fault: Fault = CONFIGURATION,
) -> Problem:
    """Return a problem of one value; a doubtful one may be right on some robot."""
    place = f"{printable(str(file))}: {key} is {printable(str(value))}"
    text = Message(
        "{place}: {reason}; allowed: {allowed}", place=place, reason=reason, allowed=allowed
    )
    fault = fault.as_warning() if doubtful else fault
    return Problem(text.reporting_only(fault), str(file), key, str(value))
