"""Sentences for people: an English template with named values, which a client can translate."""

from __future__ import annotations

import json
import re
import string
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, Iterator, Mapping, Tuple, Union

# Between sentences in a row, such as two reasons for one refusal.
BETWEEN_SENTENCES = "; "

# A template from elsewhere may neither look into its values nor ask for a gigabyte of blanks.
FIELD_FORMAT = re.compile(r"[<>+]?0?\d?\d?(\.\d\d?)?[defgs%]?")

# More than any message of the robot has; the text of a received one is bounded by it.
MAX_JSON_CHARACTERS = 16_384
# Far deeper ones are read, but exceed the recursion limit where they are shown.
MAX_DEPTH = 32

Value = Union[str, int, float, "Message", Tuple["Message", ...]]


@dataclass(frozen=True, init=False)
class Message:
    """A sentence that a person reads.

    `Message("the height {height_m:.3f} m is below {low_m:g} m", height_m=h, low_m=0.02)`. The
    template is the key of the catalogue (`gpr20_common.catalogue`), so it is written as a
    literal: `scripts/translations.sh` finds it there.

    Attributes:
        template: English, with fields as `str.format` knows them.
        values: What goes into the fields: text, numbers, and messages that are translated too.
        details: Technical words that are not translated: a command, an errno, a node's name.
    """

    template: str
    values: Mapping[str, Value]
    details: str

    def __init__(self, template: str, /, *, details: object = "", **values: object) -> None:
        """Make the message; a value of another type than text, number or message becomes text.

        Raises:
            KeyError: The template has a field without a value.
            ValueError: A value does not fit the format of its field.
        """
        object.__setattr__(self, "template", template)
        object.__setattr__(self, "values", {name: _value(one) for name, one in values.items()})
        object.__setattr__(self, "details", str(details))
        # A fault in a template shows where it is written and not where it is read.
        self.sentence()

    def sentence(self, translate: Callable[[str], str] = str) -> str:
        """Return the sentence without its details.

        Args:
            translate: Returns the translation of a template; without it the text is English.
        """
        return translate(self.template).format(
            **{name: _shown(one, translate) for name, one in self.values.items()}
        )

    @property
    def all_details(self) -> Tuple[str, ...]:
        """The details of this message and of those inside it, each once, the innermost last."""
        found = dict.fromkeys(one.details for one in self.nested() if one.details)
        return tuple(found)

    def to_json(self) -> str:
        """Return template, values and details as JSON, as they travel on the ROS graph."""
        return json.dumps(self._record(), ensure_ascii=False)

    def __str__(self) -> str:
        """Return the complete English text, as logs and `rostopic echo` show it."""
        details = BETWEEN_SENTENCES.join(self.all_details)
        return f"{self.sentence()} ({details})" if details else self.sentence()

    def __hash__(self) -> int:
        return hash((self.template, self.details))

    def nested(self) -> Iterator[Message]:
        """Yield this message and those inside it."""
        yield self
        for value in self.values.values():
            for one in value if isinstance(value, tuple) else (value,):
                if isinstance(one, Message):
                    yield from one.nested()

    def _record(self) -> Dict[str, Any]:
        record: Dict[str, Any] = {"template": self.template, "values": {}}
        for name, value in self.values.items():
            record["values"][name] = _sent(value)
        if self.details:
            record["details"] = self.details
        return record


def verbatim(text: str) -> Message:
    """Return a message for text that comes from elsewhere and stays as it is."""
    return Message("{text}", text=text)


def in_a_row(messages: Iterable[Message]) -> Message:
    """Return one message that says several, one after the other."""
    return Message("{sentences}", sentences=tuple(messages))


def received_message(text: str, message_json: str) -> Message:
    """Return a message as it came from the ROS graph or out of a file.

    Args:
        text: The complete English text.
        message_json: What `Message.to_json` returned. If it is empty, unreadable or too long,
            the message is the text as it is.
    """
    if len(message_json) > MAX_JSON_CHARACTERS:
        return verbatim(text)
    try:
        message = _message(json.loads(message_json))
        # Half of a character, which JSON can hold, can be neither sent nor shown.
        str(message).encode("utf-8")
        return message
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
        return verbatim(text)


def _message(record: Any, depth: int = 1) -> Message:
    if depth > MAX_DEPTH:
        raise ValueError(f"messages are nested more than {MAX_DEPTH} levels deep")
    fields = set()
    for _words, name, field_format, _conversion in string.Formatter().parse(record["template"]):
        if name is None:
            continue
        if not (name.isidentifier() and FIELD_FORMAT.fullmatch(str(field_format))):
            raise ValueError(f"the field {name!r} of a template has no plain name or format")
        # Each level of messages inside messages would double the text.
        if name in fields and isinstance(record["values"][name], (dict, list)):
            raise ValueError(f"the field {name!r} repeats a message")
        fields.add(name)
    values = {}
    for name, value in record["values"].items():
        if isinstance(value, dict):
            value = _message(value, depth + 1)
        elif isinstance(value, list):
            value = tuple(_message(one, depth + 1) for one in value)
        values[name] = value
    return Message(record["template"], details=record.get("details", ""), **values)


def _value(value: object) -> Value:
    if isinstance(value, (str, int, float, Message)):
        return value
    if isinstance(value, tuple) and all(isinstance(one, Message) for one in value):
        return value
    # numpy's numbers; item() is the Python number, and refuses arrays of several.
    item = getattr(value, "item", None)
    try:
        number = item() if callable(item) else None
    except (ValueError, TypeError):
        number = None
    return number if isinstance(number, (int, float)) else str(value)


def _sent(value: Value) -> Any:
    if isinstance(value, Message):
        return value._record()
    if isinstance(value, tuple):
        return [one._record() for one in value]
    return value


def _shown(value: Value, translate: Callable[[str], str]) -> Union[str, int, float]:
    if isinstance(value, Message):
        return value.sentence(translate)
    if isinstance(value, tuple):
        return BETWEEN_SENTENCES.join(one.sentence(translate) for one in value)
    return value
