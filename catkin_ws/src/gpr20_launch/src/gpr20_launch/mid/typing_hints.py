"""What a person probably meant who made a typing error in a file of the configuration."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Any, Iterable, Optional

from gpr20_common.message import Message
from gpr20_launch.mid.pin_table import BOARD_OF_GPIO, NOT_GPIO

_COMMA = re.compile(r"[+-]?\d+,\d+")
_EXPONENT = re.compile(r"[+-]?\d+[eE][+-]?\d+")
_UNIT = re.compile(r"([+-]?\d+(?:[.,]\d+)?)\s*([A-Za-zµ°%/]+)")
_GPIO = re.compile(r"(?:GPIO|BCM)[ _]?(\d{1,2})", re.IGNORECASE)
_NO_SPACE = re.compile(r"^\s*[A-Za-z]\w*:[^\s#]")
# A longer file is none of ours.
MAX_CHARACTERS = 1 << 16


def hint_for_value(key: str, value: Any) -> Optional[Message]:
    """Return what is wrong with a value that was refused; None if that is not known."""
    if key.endswith("_pin"):
        gpio = _GPIO.fullmatch(value.strip()) if isinstance(value, str) else None
        board = BOARD_OF_GPIO.get(int(gpio.group(1))) if gpio else None
        if board is not None:
            return Message(
                "the numbers are those of the header: {name} is pin {pin}", name=value, pin=board
            )
        if isinstance(value, int) and value in NOT_GPIO:
            return Message("pin {pin} is {what}", pin=value, what=NOT_GPIO[value])
    if not isinstance(value, str):
        return None
    text = value.strip()
    if _COMMA.fullmatch(text):
        return Message("write a point, not a comma: {number}", number=text.replace(",", "."))
    if _EXPONENT.fullmatch(text):
        number = re.sub("[eE]", ".0e", text)
        return Message("YAML needs a point in such a number: {number}", number=number)
    unit = _UNIT.fullmatch(text)
    if unit:
        return Message("write the number without its unit: {number}", number=unit.group(1))
    if re.fullmatch(r"0+[1-9]\d*", text):
        return Message("write the number without zeros before it: {number}", number=int(text))
    if re.fullmatch(r"[+-]?[\d.]+", text):
        return Message("write the number without quotes, with one point at most")
    return None


def hint_for_key(key: Any, known: Iterable[str]) -> Optional[Message]:
    """Return what an unknown key was meant to be; None if that is not known."""
    if not isinstance(key, str):
        return None
    names = {re.sub(r"[\W_]", "", name.lower()): name for name in known}
    wanted = re.sub(r"[\W_]", "", key.lower())
    near = difflib.get_close_matches(wanted, names, n=1, cutoff=0.75)
    return Message("perhaps {name} is meant", name=names[near[0]]) if near else None


def hint_for_text(path: Path) -> Optional[Message]:
    """Return which line of a file probably makes it no YAML, or no lines of keys and values."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            lines = file.read(MAX_CHARACTERS).splitlines()
    except OSError:
        return None
    for number, line in enumerate(lines, 1):
        if re.match(r"\s*\t", line):
            return Message("line {line} begins with a tab; write spaces", line=number)
        if _NO_SPACE.match(line):
            return Message("in line {line} a space is missing behind the colon", line=number)
    return None


def with_hint(reason: Message, hint: Optional[Message]) -> Message:
    """Return a sentence with a hint behind it."""
    if hint is None:
        return reason
    return Message("{reason}; {hint}", reason=reason, hint=hint).with_fault(reason.fault)
