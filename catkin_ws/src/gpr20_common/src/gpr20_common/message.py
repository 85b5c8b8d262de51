"""Sentences for people, which a client can translate, the fault behind one, and both as JSON."""

from __future__ import annotations

import contextlib
import enum
import json
import re
from collections import Counter
from dataclasses import dataclass, field, replace
from math import isfinite
from numbers import Integral, Real
from typing import Any, Callable, Dict, Iterable, Iterator, Mapping, Optional, Tuple, Union

from gpr20_common.terminal_text import printable

# Between sentences in a row, such as two reasons for one refusal.
BETWEEN_SENTENCES = "; "

CODE_FORMAT = re.compile(r"[a-z][a-z0-9_]{0,29}\.[a-z][a-z0-9_]{0,59}")

# Of what is read, which may come from another version of the software, or from anybody. A template
# may neither look into its values nor ask for a gigabyte of blanks.
FIELD = re.compile(r"\{([^\W\d]\w*)(?::[<>+]?0?\d?\d?(?:\.\d\d?)?[defgs%]?)?\}")
# More than any message of the robot has, as JSON and as text: a window shows a longer one slowly.
MAX_CHARACTERS = 16_384
# No JSON of the robot is longer.
MAX_READ_CHARACTERS = 1_000_000
# Far deeper ones are read, but exceed the recursion limit where they are shown.
MAX_DEPTH = 32
# Of a fault whose code cannot be read, or is not there.
UNKNOWN_CODE = "robot.unknown"
# What reading something that anybody may have written can raise.
UNREADABLE = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)

Value = Union[str, int, float, "Message", Tuple["Message", ...]]


class Severity(enum.Enum):
    """How much a fault matters, the gravest last."""

    NOTE = "note"  # asked for, or harmless: nobody has to do anything
    WARNING = "warning"  # the robot continues; somebody should look
    FAULT = "fault"  # something did not succeed


@dataclass(frozen=True)
class Fault:
    """What a program knows of something that went wrong; people read the sentence that reports it.

    Attributes:
        code: `area.what`, such as `vna.not_calibrated`. It stays when the sentence is reworded.
        remedy: What a person does first; None: a fault inside or around knows it.
        severity: How much it matters.
        may_move: Something of the robot may still move.
        can_continue: The survey can continue when the cause is gone.
    """

    code: str
    remedy: Optional[Message] = None
    severity: Severity = Severity.FAULT
    may_move: bool = False
    can_continue: bool = True

    def as_warning(self) -> Fault:
        return replace(self, severity=Severity.WARNING)

    def as_note(self) -> Fault:
        return replace(self, severity=Severity.NOTE)

    def record(self) -> Dict[str, Any]:
        record: Dict[str, Any] = {**vars(self), "severity": self.severity.value}
        remedy = record.pop("remedy")
        if remedy is None:
            return record
        said = {f"remedy_{name}": value for name, value in remedy.record().items()}
        return {**record, "remedy": str(remedy), **said}


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
        fault: What the sentence reports, for programs; None if it reports no fault itself.
    """

    template: str
    values: Mapping[str, Value]
    details: str
    fault: Optional[Fault] = field(compare=False)

    def __init__(self, template: str, /, *, details: object = "", **values: object) -> None:
        """Make the message; a value of another type than text, number or message becomes text.

        Raises:
            KeyError, ValueError: A field has no value, or one that does not fit its format.
        """
        known = {name: _value(one) for name, one in values.items()}
        self.__dict__.update(template=template, values=known, details=str(details), fault=None)
        # A fault in a template shows where it is written and not where it is read.
        self.sentence()

    def sentence(self, translate: Callable[[str], str] = str) -> str:
        """Return the sentence without its details; `translate` translates a template."""
        point = "." if translate is str else translate(DECIMAL_POINT.template)

        def shown(value: Value) -> Any:
            if isinstance(value, tuple):
                return BETWEEN_SENTENCES.join(map(shown, value))
            if isinstance(value, Message):
                return value.sentence(translate)
            if isinstance(value, (int, float)):
                return _Number(value, point)
            # Nobody is shown what hides, fakes or controls; logs have the text as it is.
            return value if translate is str else "\n".join(map(printable, value.split("\n")))

        values = {name: shown(value) for name, value in self.values.items()}
        return translate(self.template).format(**values)

    @property
    def all_details(self) -> Tuple[str, ...]:
        """The details of this message and of those inside it, each once, the innermost last."""
        return tuple(dict.fromkeys(one.details for one in self.nested() if one.details))

    def with_fault(self, fault: Optional[Fault]) -> Message:
        return self._with(fault=fault)

    def with_details(self, details: object) -> Message:
        return self._with(details=str(details))

    def with_values(self, known: Mapping[str, Value]) -> Message:
        return self._with(values={name: known.get(name, own) for name, own in self.values.items()})

    @property
    def cause(self) -> Optional[Fault]:
        """What this sentence and those inside it report together; None: nothing.

        Code and remedy are those of the innermost fault that has a remedy, else of the innermost.
        What may move comes first, and a note, about which nobody has to do anything, last; of
        several beside each other the gravest, then the first. The rest is that of the gravest.
        """
        reported = tuple(self._reported())
        if not reported:
            return None
        _depth, found = max(reported, key=_deciding)
        knows = found.remedy is not None and found.may_move == self.may_move
        return replace(
            found,
            remedy=found.remedy if knows or not self.may_move else MOTORS_OFF,
            severity=max((one.severity for one in self.faults), key=_GRAVITY.index),
            may_move=self.may_move,
            can_continue=self.can_continue,
        )

    @property
    def faults(self) -> Tuple[Fault, ...]:
        """The faults that this sentence and those inside it report, each by itself."""
        return tuple(fault for _depth, fault in self._reported())

    def _reported(self, depth: int = 0) -> Iterator[Tuple[int, Fault]]:
        if self.fault is not None:
            yield depth, self.fault
        for inner in self.inner():
            yield from inner._reported(depth + 1)

    @property
    def severity(self) -> Optional[Severity]:
        return None if self.cause is None else self.cause.severity

    @property
    def fault_code(self) -> str:
        return "" if self.cause is None else self.cause.code

    @property
    def remedy(self) -> Optional[Message]:
        return None if self.cause is None else self.cause.remedy

    def reporting_only(self, fault: Fault) -> Message:
        """Return the sentence with this fault and none inside; what may move still does."""

        def silent(value: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(map(silent, value))
            if not isinstance(value, Message):
                return value
            values = {name: silent(one) for name, one in value.values.items()}
            return value._with(values=values, fault=None)

        if self.may_move and not fault.may_move:
            fault = replace(fault, may_move=True, remedy=MOTORS_OFF)
        return silent(self).with_fault(fault)

    def as_warning(self) -> Message:
        """Return the same sentence for something that the robot continues in spite of."""
        cause = self.cause
        if cause is None:
            return self
        return self.reporting_only(replace(cause, severity=Severity.WARNING, can_continue=True))

    @property
    def may_move(self) -> bool:
        return any(fault.may_move for fault in self.faults)

    @property
    def can_continue(self) -> bool:
        return all(fault.can_continue for fault in self.faults)

    def to_json(self) -> str:
        return json.dumps(self.record(), ensure_ascii=False)

    def record(self) -> Dict[str, Any]:
        """Return it as JSON holds it, with what it reports in the names of gpr20_msgs/Fault.

        Of a sentence inside it that is what it reports itself.
        """
        return self._record(self.cause)

    def _record(self, fault: Optional[Fault]) -> Dict[str, Any]:
        def sent(value: Value) -> Any:
            if isinstance(value, tuple):
                return [sent(one) for one in value]
            return value._record(value.fault) if isinstance(value, Message) else value

        values = {name: sent(value) for name, value in self.values.items()}
        record: Dict[str, Any] = {"sentence": self.template, "values": values}
        if self.details:
            record["details"] = self.details
        return record if fault is None else {**record, **fault.record()}

    def __str__(self) -> str:
        """Return the complete English text, as logs and `rostopic echo` show it."""
        details = BETWEEN_SENTENCES.join(self.all_details)
        return f"{self.sentence()} ({details})" if details else self.sentence()

    def __hash__(self) -> int:
        return hash((self.template, self.details))

    def nested(self) -> Iterator[Message]:
        yield self
        for inner in self.inner():
            yield from inner.nested()

    def inner(self) -> Iterator[Message]:
        for value in self.values.values():
            for one in value if isinstance(value, tuple) else (value,):
                if isinstance(one, Message):
                    yield one

    def _with(self, **changed: Any) -> Message:
        copy = object.__new__(Message)
        copy.__dict__.update(self.__dict__, **changed)
        return copy


@dataclass(frozen=True)
class _Number:
    value: float
    point: str

    def __format__(self, form: str) -> str:
        return format(self.value, form).replace(".", self.point)


_GRAVITY = list(Severity)
DECIMAL_POINT = Message(".")
MOTORS_OFF = Message("Switch off the motors' power now. Keep your hands clear.")


def verbatim(text: str) -> Message:
    """Return a message for text that comes from elsewhere and stays as it is."""
    return Message("{text}", text=text)


def numeral(value: float, form: str = "g") -> Message:
    """Return a number by itself, as people of a language write it; `form` is that of `format`."""
    if not isfinite(value):  # JSON has no number for it
        return verbatim(format(value, form))
    return Message("{number:" + form + "}", number=value)


def in_a_row(messages: Iterable[Message]) -> Message:
    return Message("{sentences}", sentences=tuple(messages))


def _deciding(reported: Tuple[int, Fault]) -> Tuple[bool, bool, bool, int, int]:
    depth, fault = reported
    has_remedy, is_note = fault.remedy is not None, fault.severity is Severity.NOTE
    return has_remedy, fault.may_move, not is_note, depth, _GRAVITY.index(fault.severity)


def _value(value: Any) -> Value:
    if isinstance(value, (str, int, float, Message)):
        return value
    if isinstance(value, tuple) and all(isinstance(one, Message) for one in value):
        return value
    if isinstance(value, Integral):  # numpy's, too
        return int(value)
    return float(value) if isinstance(value, Real) else str(value)


def received_message(text: str, record: Any) -> Message:
    """Return a message from its English text and what `Message.record` returned, maybe as JSON.

    If a sentence is missing there, unreadable or too long, it is the text, with the fault.
    """
    return _received(text, _parsed(record), 1)


def _received(text: str, record: Any, depth: int) -> Message:
    text = text.encode(errors="replace").decode()
    plain = verbatim(text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}…")
    if not isinstance(record, dict):
        return plain
    try:
        message = _message(record, depth)
        shown, sent = str(message), message.to_json()
        # A template can repeat a value.
        if max(len(shown), len(sent)) > MAX_CHARACTERS:
            raise ValueError("it is too long to be shown")
        # Half of a character, which JSON can hold, can be neither sent nor shown.
        f"{shown}{sent}".encode()
        return message
    except UNREADABLE:
        return plain.with_fault(_fault(record, depth))


def _parsed(value: Any) -> Any:
    """Return a value that may have come as JSON; None if that is none, or far too long."""
    if not isinstance(value, str):
        return value
    with contextlib.suppress(*UNREADABLE):
        return json.loads(value) if len(value) <= MAX_READ_CHARACTERS else None
    return None


def _message(record: Any, depth: int) -> Message:
    values, sentence = _parsed(record["values"]), record["sentence"]
    if depth > MAX_DEPTH:
        raise ValueError(f"messages are nested more than {MAX_DEPTH} levels deep")
    plain = sentence.replace("{{", "").replace("}}", "")
    names = Counter(FIELD.findall(plain))
    if not plain or set("{}") & set(FIELD.sub("", plain)):
        raise ValueError("it has no sentence, or a field without a plain name or format")
    for name, value in values.items():
        # Each level of messages inside messages would double the text.
        if isinstance(value, (dict, list)) and names[name] > 1:
            raise ValueError(f"the field {name!r} repeats a message")
        if isinstance(value, dict):
            value = _message(value, depth + 1)
        elif isinstance(value, list):
            value = tuple(_message(one, depth + 1) for one in value)
        values[name] = value
    message = Message(sentence, details=record.get("details", ""), **values)
    return message.with_fault(_fault(record, depth))


def _fault(record: Dict[str, Any], depth: int) -> Optional[Fault]:
    """Read the fault of a message; what a later version may have changed is taken as grave."""
    code = str(record.get("code", ""))
    moves = record.get("may_move", bool(code)) is not False
    if not (code or moves or record.get("remedy")):
        return None
    named = {one.value: one for one in Severity}
    said = {name: record.get(f"remedy_{name}") for name in ("sentence", "values")}
    remedy = _received(str(record.get("remedy", "")), said, depth + 1)
    return Fault(
        code=code if CODE_FORMAT.fullmatch(code) else UNKNOWN_CODE,
        remedy=remedy if str(remedy) else None,
        severity=named.get(str(record.get("severity")), Severity.FAULT),
        may_move=moves,
        can_continue=record.get("can_continue", True) is True,
    )
