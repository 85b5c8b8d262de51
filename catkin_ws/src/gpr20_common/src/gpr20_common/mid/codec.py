"""Records of files, parameters and JSON as dataclasses, and back; pydantic converts them.

Nothing is taken for something else: a text is no number, `true` is no 1, a key that nobody knows is
a mistake, and no number is NaN. What does not fit is named, such as `scene/targets[2]/depth_m`.
"""

from __future__ import annotations

import dataclasses
import functools
import typing
from typing import Any, Dict, Hashable, Literal, Mapping, Sequence, Tuple, Type, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

from gpr20_common.errors import ConfigurationError, Gpr20Error, InvalidValueError
from gpr20_common.message import Message, numeral, verbatim

Record = TypeVar("Record")
UNKNOWN_KEY = "unexpected_keyword_argument"
SHOWN = 200  # characters of a value
NUMBER, WHOLE, GROUP = Message("a number"), Message("a whole number"), Message("a group of values")
WANTED = {  # by the codes of pydantic
    **{"bool_type": Message("true or false"), "string_type": Message("a text")},
    **{"float_type": NUMBER, "finite_number": NUMBER, "int_type": WHOLE},
    **{"tuple_type": Message("a list"), "dataclass_type": GROUP, "dict_type": GROUP},
}


def bounded(lower: float, upper: float, default: Any = dataclasses.MISSING) -> Any:
    """Declare a number of a record with the bounds it must lie within, both included."""
    return dataclasses.field(default=default, metadata={"ge": lower, "le": upper})


def record_from(kind: Type[Record], values: Any, place: str, others: bool = False) -> Record:
    """Make a record of what was read, or raise an InvalidValueError.

    The kind is a dataclass, or a list or group of them; a field without a default must be there.
    The place is where it was found, for the messages; empty if they name it themselves. With
    `others` unknown keys are ignored.
    """
    try:
        # In JSON a list is a tuple, and a choice is its value.
        content = _any("constants").dump_json(values)
    except ValueError as error:
        reason = Message("{place} holds what no file can hold", place=place, details=error)
        raise InvalidValueError(reason) from error
    return record_of_json(kind, content, place, others)


def record_of_json(kind: Type[Record], content: bytes, place: str, others: bool = False) -> Record:
    """Do for strict JSON what `record_from` does."""
    adapter = _adapter(typing.cast(Hashable, kind), others)
    try:
        return adapter.validate_json(b"[%b]" % content)[0]
    except ValidationError as error:
        # Before a value that does not fit comes a misspelt key.
        found = min(error.errors(), key=lambda one: one["type"] != UNKNOWN_KEY)
        raise _refusal(found, kind, place) from error


def mistakes(kind: Type, values: Any, place: str) -> Dict[str, Message]:
    """Return why values are no record: the first reason of each key; "": of several together."""
    try:
        record_from(kind, values, place)
    except InvalidValueError as error:
        cause = error.__cause__
        single = cause.errors() if isinstance(cause, ValidationError) else []
        found = [("".join(map(str, one["loc"][1:2])), one) for one in reversed(single)]
        reasons = {key: _refusal(one, kind, place).message for key, one in found}
        return reasons or {"": error.message}
    return {}


def shortened(value: Any) -> str:
    """Return a value cut to what a message can hold; a text is in quotes."""
    text = str(value)
    text = text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."
    return repr(text) if isinstance(value, str) else text


def plain(record: Any) -> Any:
    """Return a record as JSON and YAML hold it; a number that is not finite becomes None."""
    return _any("null").dump_python(record, mode="json")


@functools.lru_cache(maxsize=None)
def _any(not_finite: Literal["constants", "null"]) -> TypeAdapter:
    return TypeAdapter(Any, config=ConfigDict(ser_json_inf_nan=not_finite))


@functools.lru_cache(maxsize=None)
def _adapter(kind: Any, others: bool) -> TypeAdapter:
    # A dataclass of the standard library has the configuration of what is around it.
    extra = "ignore" if others else "forbid"
    config = ConfigDict(strict=True, allow_inf_nan=False, extra=extra)  # type: ignore[typeddict-item]
    return TypeAdapter(Tuple[kind], config=config)


def _refusal(found: Mapping[str, Any], kind: Any, place: str) -> Gpr20Error:
    """Return what refuses a value that pydantic does not accept."""
    keys = [one for one in found["loc"][1:] if one != "[key]"]
    context: Dict[str, Any] = found.get("ctx", {})
    for key in keys:
        below = f"{place}/{key}" if place else str(key)
        place = f"{place}[{key}]" if isinstance(key, int) else below
    if isinstance(context.get("error"), Gpr20Error):
        return context["error"]  # the record refuses itself
    if found["type"] == "missing":
        return ConfigurationError(Message("{place} is missing", place=place))
    if found["type"] == UNKNOWN_KEY:
        known = ", ".join(sorted(_fields_at(kind, keys[:-1])))
        text = Message("{place} is unknown; allowed: {known}", place=place, known=known)
        return ConfigurationError(text)
    if found["type"] == "json_invalid":
        return InvalidValueError(Message("the file is not strict JSON", details=found["msg"]))
    named: Dict[str, Any] = {"place": place, "value": shortened(found["input"])}
    if "ge" in context or "le" in context:
        bounds = _fields_at(kind, keys[:-1])[str(keys[-1])].metadata
        lower, upper = (numeral(bounds[one], ".12g") for one in ("ge", "le"))
        named.update(name=place, lower=lower, upper=upper)
        text = Message("{name} is {value}; it must lie between {lower} and {upper}", **named)
    elif "expected" in context:
        allowed = context["expected"].replace(" or ", ", ").replace("'", "")
        text = Message("{place} is {value}; it must be one of {allowed}", allowed=allowed, **named)
    else:
        wanted = WANTED.get(found["type"], verbatim(found["msg"]))
        text = Message("{place} is {value}; it must be {wanted}", wanted=wanted, **named)
    return InvalidValueError(text)


def _fields_at(kind: Any, keys: Sequence[Any]) -> Dict[str, dataclasses.Field]:
    """Return the fields of a record inside another one."""
    for key in keys:
        # Of Tuple[X, ...] the first, of Mapping[K, X] the last.
        inside = [one for one in typing.get_args(kind) if one is not ...]
        kind = inside[-1] if inside else typing.get_type_hints(kind)[key]
        if typing.get_origin(kind) is typing.Union:  # Optional[...]
            kind = typing.get_args(kind)[0]
    return {one.name: one for one in dataclasses.fields(kind)}
