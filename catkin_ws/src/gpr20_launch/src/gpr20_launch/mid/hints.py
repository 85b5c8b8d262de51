"""What a person probably meant by a mistake."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Any, Iterable

from gpr20_launch.mid.pin_table import BOARD_OF_GPIO, NOT_GPIO

# Begins the value of what the import could not find out and a person must write.
UNREAD = "UNREAD"
# What a text that should be a number matches, and what is said of it.
_NUMBERS = (
    (
        re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+"),
        "a comma may be a point or none at all: write the number without it",
    ),
    (re.compile(r"([+-]?\d+),(\d+)"), r"write a point, not a comma: \1.\2"),
    (
        re.compile(r"([+-]?\d+)(?:\.(\d*))?[eE]([+-]?)(\d+)"),
        "YAML needs a point and a sign in such a number, such as 1.0e-4 and 2.0e+9",
    ),
    (
        re.compile(r"([+-]?\d+(?:[.,]\d+)?)\s*[A-Za-zµ°%/]+"),
        r"write the number without its unit: \1",
    ),
    (re.compile(r"0+([1-9]\d*)"), r"write the number without zeros before it: \1"),
    (re.compile(r"[+-]?\d*\.?\d+"), "write the number without quotes"),
)
_GPIO = re.compile(r"(?:GPIO|BCM)[ _]?(\d{1,2})", re.IGNORECASE)
# A longer file is none of ours.
MAX_BYTES = 1 << 16
_WRONG_LINES = (
    (re.compile("\ufffd"), "is not UTF-8: save the file as UTF-8"),
    (re.compile(r"\s*\t"), "begins with a tab; write spaces"),
    (re.compile(r"[\x00-\x08\x0e-\x1f\x7f]"), "holds what is no text"),
    (re.compile(r"[\u00a0\u2000-\u200f\ufeff]"), "has a space of another kind; write a plain one"),
    (re.compile(r"^\s*[A-Za-z]\w*:[^\s#]"), "lacks a space behind the colon"),
)


def hint_for_value(key: str, value: Any, allowed: str = "") -> str:
    """Return what is wrong with a value that was refused; empty if that is not known."""
    if key.endswith("_pin") and isinstance(value, int) and value in NOT_GPIO:
        return f"pin {value} is {NOT_GPIO[value]}"
    if not isinstance(value, str):
        return ""
    text = value.strip()
    if text.startswith(UNREAD):
        return "the import could not read it: write the value"
    gpio = _GPIO.fullmatch(text)
    if key.endswith("_pin") and gpio and int(gpio.group(1)) in BOARD_OF_GPIO:
        pin = BOARD_OF_GPIO[int(gpio.group(1))]
        return f"the numbers are those of the header: {text} is pin {pin}"
    for pattern, said in _NUMBERS:
        found = pattern.fullmatch(text)
        if found:
            return found.expand(said)
    return hint_for_key(text, allowed.split(", "))


def hint_for_key(key: Any, known: Iterable[str]) -> str:
    """Return a sentence that names the nearest of the known words."""
    names = {re.sub(r"[\W_]", "", name.lower()): name for name in known if name}
    wanted = re.sub(r"[\W_]", "", str(key).lower())
    near = difflib.get_close_matches(wanted, names, n=1, cutoff=0.75)
    return f"perhaps {names[near[0]]} is meant" if near else ""


def hint_for_text(path: Path) -> str:
    """Return which line of a file probably makes it no YAML, or no lines of keys and values."""
    with path.open("rb") as file:
        content = file.read(MAX_BYTES)
    wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    lines = content.decode("utf-16" if wide else "utf-8", "replace").split("\n")
    said = (
        f"line {number} {what}"
        for number, line in enumerate(lines, 1)
        for pattern, what in _WRONG_LINES
        if pattern.search(line)
    )
    return next(said, "")
