"""What a person probably meant by a mistake, and which key of a file is to blame for it."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Any, Iterable, Mapping, Optional, Tuple, Type

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_launch.mid.pin_table import BOARD_OF_GPIO, NOT_GPIO

# Begins the value of what a program could not find out and a person must write.
UNREAD = "UNREAD"
_COMMA = re.compile(r"[+-]?\d+,\d+")
_EXPONENT = re.compile(r"([+-]?\d+)(\.\d*)?[eE]([+-]?)(\d+)")
_UNIT = re.compile(r"([+-]?\d+(?:[.,]\d+)?)\s*([A-Za-zµ°%/]+)")
_GPIO = re.compile(r"(?:GPIO|BCM)[ _]?(\d{1,2})", re.IGNORECASE)
_NO_SPACE = re.compile(r"^\s*[A-Za-z]\w*:[^\s#]")
# A longer file is none of ours.
MAX_BYTES = 1 << 16
# Keys that have no meaning without another.
TOGETHER: Mapping[str, Tuple[str, ...]] = {
    "latitude_deg": ("longitude_deg",),
    "longitude_deg": ("latitude_deg",),
    "sensor_pin": ("endstop_active", "endstop_pull"),
    "enable_pin": ("enable_active",),
    "controller": ("controller_options",),
    "analyzer": ("analyzer_options", "address"),
}
# Of these numbers, and those of the others, one suits almost every key; more pins than an axis has.
TRIALS = (0.0, 1.0, 50.0, 1.0e3, -1.0e5, 1.0e5, 1.0e-3, 1.0e-5, 1.0e12, 7, 22, 33, 35, 36)


def hint_for_value(key: str, value: Any, error: Message) -> Optional[Message]:
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
    if text.startswith(UNREAD):
        return Message("the import could not read it: write the value")
    if re.fullmatch(r"[+-]?[1-9]\d{0,2}(,\d{3})+", text):
        return Message("a comma may be a point or none at all: write the number without it")
    if _COMMA.fullmatch(text):
        return Message("write a point, not a comma: {number}", number=text.replace(",", "."))
    parts = _EXPONENT.fullmatch(text)
    if parts:
        whole, fraction, sign, power = parts.groups()
        number = f"{whole}{fraction or '.0'}e{sign or '+'}{power}"
        return Message("YAML needs a point and a sign in such a number: {number}", number=number)
    unit = _UNIT.fullmatch(text)
    if unit:
        return Message("write the number without its unit: {number}", number=unit.group(1))
    if re.fullmatch(r"0+[1-9]\d*", text):
        return Message("write the number without zeros before it: {number}", number=int(text))
    if re.fullmatch(r"[+-]?\d*\.?\d+", text):
        return Message("write the number without quotes")
    return hint_for_key(text, str(error.values.get("allowed", "")).split(", "))


def nearest(key: Any, known: Iterable[str]) -> Optional[str]:
    """Return what an unknown word was meant to be; None if that is not known."""
    names = {re.sub(r"[\W_]", "", name.lower()): name for name in known if name}
    wanted = re.sub(r"[\W_]", "", str(key).lower())
    near = difflib.get_close_matches(wanted, names, n=1, cutoff=0.75)
    return names[near[0]] if near else None


def hint_for_key(key: Any, known: Iterable[str]) -> Optional[Message]:
    """Return a sentence that names the nearest of the known words."""
    near = nearest(key, known)
    return None if near is None else Message("perhaps {name} is meant", name=near)


def hint_for_text(path: Path) -> Optional[Message]:
    """Return which line of a file probably makes it no YAML, or no lines of keys and values."""
    try:
        with path.open("rb") as file:
            lines = file.read(MAX_BYTES).splitlines()
    except OSError:
        return None
    for number, raw in enumerate(lines, 1):
        line = raw.decode("utf-8", "replace")
        if "\ufffd" in line and not raw.startswith((b"\xff\xfe", b"\xfe\xff")):
            return Message("line {line} is not UTF-8: save the file as UTF-8", line=number)
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


def refusal(kind: Type, values: Mapping[str, Any], place: str) -> Optional[Message]:
    """Return why a record cannot be made of values; None if it can."""
    try:
        record_from(kind, values, place)
    except InvalidValueError as error:
        return error.message
    return None


def culprit(
    kind: Type, own: Mapping[str, Any], place: str, base: Mapping[str, Any], error: Message
) -> str:
    """Return the key that causes an error; empty if no key of the file does."""

    def without(key: str) -> Optional[Message]:
        rest = {one: value for one, value in own.items() if one != key}
        return refusal(kind, {**base, **rest}, place)

    cures = [key for key in own if without(key) is None]
    # Of two numbers that must be there together: the one that a harmless one cures.
    numbers = [key for key, value in own.items() if type(value) in (int, float)]
    cures += [one for one in numbers if not refusal(kind, {**base, **own, one: 0.0}, place)]
    return next(iter([*cures, *(key for key in own if without(key) != error)]), "")


def follows(
    kind: Type, own: Mapping[str, Any], place: str, base: Mapping[str, Any], unsure: Iterable[str]
) -> bool:
    """Return whether values may go together if those that are wrong or misspelt are corrected."""
    values = {**base, **own}
    trials = {*TRIALS, *(one for one in values.values() if type(one) in (int, float))}
    return any(
        refusal(kind, {**values, key: trial}, place) is None for key in unsure for trial in trials
    )
