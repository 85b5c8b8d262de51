"""What is wrong with a robot's configuration, as data."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

from gpr20_common.message import Fault, Message, Severity
from gpr20_common.terminal_text import printable
from gpr20_launch import faults

# Under which name a sentence holds what is allowed.
_ALLOWED = ("allowed", "known", "pins", "example")


@dataclass(frozen=True)
class Problem:
    """A mistake, which refuses a launch, or something doubtful, which a person must look at.

    Attributes:
        text: The whole sentence, with file, key, value and what is allowed, and its fault.
        file: Where it is.
        key: Of the value, such as x/dir_pin; empty: the file itself.
        value: As it was found.
        allowed: What the value may be, as far as one list or range says it.
        pin: BOARD number; None: it is not about a pin.
        uses: Both uses of that pin, or its use and what the header has there.
    """

    text: Message
    file: Path
    key: str = ""
    value: str = ""
    allowed: str = ""
    pin: Optional[int] = None
    uses: Tuple[str, ...] = ()

    @property
    def is_mistake(self) -> bool:
        """Whether it refuses a launch."""
        cause = self.text.cause
        return cause is None or cause.severity is Severity.FAULT

    def record(self) -> Dict[str, Any]:
        """Return the sentence as it travels, and the rest beside it."""
        others = {name: getattr(self, name) for name in ("key", "value", "allowed", "pin")}
        return {
            **json.loads(self.text.to_json()),
            "file": printable(self.file),
            "uses": list(self.uses),
            **others,
        }


def problem(
    file: Path,
    reason: Message,
    key: str = "",
    value: object = "",
    fault: Fault = faults.WRONG_VALUE,
    place: str = "",
    allowed: str = "",
) -> Problem:
    """Return a problem whose sentence begins with its file.

    Args:
        file: Where it is.
        reason: What is wrong; it names key, value and what is allowed.
        key: Of the value.
        value: As it was found.
        fault: Mistake or doubtful.
        place: Named between file and reason.
        allowed: What the value may be; empty: as the reason has it.
    """
    text = (
        Message("{file}, {place}: {reason}", file=printable(file), place=place, reason=reason)
        if place
        else Message("{file}: {reason}", file=printable(file), reason=reason)
    )
    return Problem(text.with_fault(fault), file, key, str(value), allowed or _allowed(reason))


def _allowed(reason: Message) -> str:
    for inner in reason.nested():
        values = inner.values
        if "lower" in values and "upper" in values:
            return f"{values['lower']} - {values['upper']}"
        for name in _ALLOWED:
            if name in values:
                return str(values[name])
    return ""
