"""What the check of a robot's configuration finds, as data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Tuple, Union

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
        allowed: What would be allowed.
        uses: Of a pin with two purposes: everything that uses it.
    """

    message: Message
    file: str = ""
    key: str = ""
    value: str = ""
    allowed: str = ""
    uses: Tuple[str, ...] = ()

    @property
    def refuses(self) -> bool:
        """Whether the robot must not be launched; otherwise it is doubtful."""
        cause = self.message.cause
        return cause is None or cause.severity is Severity.FAULT

    def record(self) -> Dict[str, Any]:
        """Return the sentence as it travels, and the rest beside it."""
        own = {name: getattr(self, name) for name in ("file", "key", "value", "allowed")}
        return {**self.message.record(), **own, "uses": list(self.uses)}


def problem(
    file: Union[Path, str],
    key: str,
    value: object,
    reason: Message,
    allowed: Union[Message, str],
    doubtful: bool = False,
    uses: Tuple[str, ...] = (),
    fault: Fault = CONFIGURATION,
) -> Problem:
    """Return a problem of one value, whose sentence names file, key, value and what is allowed.

    A doubtful value may be right on some robot; it refuses no launch.
    """
    text = Message(
        "{file}: {key} is {value}: {reason}; allowed: {allowed}",
        file=printable(str(file)),
        key=key,
        value=printable(str(value)),
        reason=reason,
        allowed=allowed,
    ).reporting_only(fault)
    text = text.as_warning() if doubtful else text
    return Problem(text, str(file), key, str(value), str(allowed), uses)
