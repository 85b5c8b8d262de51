"""Which key of a file is to blame for values that are refused together."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Tuple, Type

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.records import record_from

# Keys that have no meaning without another.
TOGETHER: Mapping[str, Tuple[str, ...]] = {
    "latitude_deg": ("longitude_deg",),
    "longitude_deg": ("latitude_deg",),
    "sensor_pin": ("endstop_active", "endstop_pull"),
    "enable_pin": ("enable_active",),
    "controller": ("controller_options",),
    "analyzer": ("analyzer_options", "address"),
}


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
