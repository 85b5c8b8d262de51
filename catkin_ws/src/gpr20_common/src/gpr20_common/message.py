"""Sentences for people, which a client can translate, and the fault behind one, for programs."""

from __future__ import annotations

import enum
import json
import re
from dataclasses import dataclass, field, fields
from typing import Any, Callable, Dict, Iterable, Iterator, Mapping, Optional, Tuple, Union

# Between sentences in a row, such as two reasons for one refusal.
BETWEEN_SENTENCES = "; "

CODE_FORMAT = re.compile(r"[a-z][a-z0-9_]{0,29}\.[a-z][a-z0-9_]{0,59}")

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
        replaces: It decides, and not the faults inside its sentence.
    """

    code: str
    remedy: Optional[Message] = None
    severity: Severity = Severity.FAULT
    may_move: bool = False
    can_continue: bool = True
    replaces: bool = False

    def __post_init__(self) -> None:
        if not CODE_FORMAT.fullmatch(self.code):
            raise ValueError(f"the code {self.code!r} of a fault must have the form area.what")

    @property
    def gravity(self) -> int:
        return list(Severity).index(self.severity)

    def record(self) -> Dict[str, Any]:
        """Return it as JSON holds it; what has its usual value is left out."""
        record: Dict[str, Any] = {"code": self.code, "severity": self.severity.value}
        for name in ("may_move", "can_continue", "replaces"):
            if getattr(self, name) != getattr(Fault, name):
                record[name] = getattr(self, name)
        if self.remedy is not None:
            record["remedy"] = self.remedy.record()
        return record


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
        self._set(template=template, values=known, details=str(details), fault=None)
        # A fault in a template shows where it is written and not where it is read.
        self.sentence()

    def sentence(self, translate: Callable[[str], str] = str) -> str:
        """Return the sentence without its details; `translate` translates a template."""

        def shown(value: Value) -> Any:
            if isinstance(value, tuple):
                return BETWEEN_SENTENCES.join(map(shown, value))
            return value.sentence(translate) if isinstance(value, Message) else value

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
        """Return the same sentence with the known values of its fields."""
        return self._with(values={name: known.get(name, own) for name, own in self.values.items()})

    @property
    def cause(self) -> Optional[Fault]:
        """The fault that decides; None if neither this sentence nor one inside reports one.

        It is the innermost that has a remedy, unless one around it replaces it or is graver. Of
        several beside each other it is the most urgent, and the first of those.
        """
        own = self.fault
        if own is not None and own.replaces:
            return own
        inside = [one for one in (inner.cause for inner in self._inner()) if one is not None]
        deciding = _most_urgent(one for one in inside if one.remedy is not None)
        if own is None or own.remedy is None:
            return deciding or own or _most_urgent(inside)
        return own if deciding is None or deciding.gravity < own.gravity else deciding

    @property
    def faults(self) -> Tuple[Fault, ...]:
        """The faults that this sentence and those inside it report; none inside a replaced one."""
        own = () if self.fault is None else (self.fault,)
        if own and own[0].replaces:
            return own
        return own + tuple(fault for inner in self._inner() for fault in inner.faults)

    @property
    def fault_code(self) -> str:
        return "" if self.cause is None else self.cause.code

    @property
    def remedy(self) -> Optional[Message]:
        return None if self.cause is None else self.cause.remedy

    @property
    def failure(self) -> Optional[Message]:
        """What did not succeed: the outermost sentences that report that, without those around.

        None if the sentence reports at most notes and warnings.
        """
        failing = tuple(self._failing())
        if len(failing) > 1:
            return in_a_row(failing)
        return failing[0] if failing else None

    def as_warning(self) -> Message:
        """Return the same sentence for something that the robot continues in spite of."""
        cause = self.cause
        if cause is None:
            return self
        return self.with_fault(
            Fault(cause.code, cause.remedy, Severity.WARNING, self.may_move, replaces=True)
        )

    @property
    def may_move(self) -> bool:
        # What moves does so whatever the first step is.
        return any(one.fault.may_move for one in self.nested() if one.fault is not None)

    @property
    def can_continue(self) -> bool:
        return all(fault.can_continue for fault in self.faults)

    def to_json(self) -> str:
        """Return template, values, details and fault as JSON, as they travel on the ROS graph."""
        return json.dumps(self.record(), ensure_ascii=False)

    def record(self) -> Dict[str, Any]:
        """Return it as JSON holds it; what is empty is left out."""

        def sent(value: Value) -> Any:
            if isinstance(value, tuple):
                return [sent(one) for one in value]
            return value.record() if isinstance(value, Message) else value

        values = {name: sent(value) for name, value in self.values.items()}
        record: Dict[str, Any] = {"template": self.template, "values": values}
        if self.details:
            record["details"] = self.details
        if self.fault is not None:
            record["fault"] = self.fault.record()
        return record

    def __str__(self) -> str:
        """Return the complete English text, as logs and `rostopic echo` show it."""
        details = BETWEEN_SENTENCES.join(self.all_details)
        return f"{self.sentence()} ({details})" if details else self.sentence()

    def __hash__(self) -> int:
        return hash((self.template, self.details))

    def nested(self) -> Iterator[Message]:
        yield self
        for inner in self._inner():
            yield from inner.nested()

    def _inner(self) -> Iterator[Message]:
        for value in self.values.values():
            for one in value if isinstance(value, tuple) else (value,):
                if isinstance(one, Message):
                    yield one

    def _failing(self) -> Iterator[Message]:
        if self.fault is not None and self.fault.severity is Severity.FAULT:
            yield self
        elif self.fault is None or not self.fault.replaces:
            for inner in self._inner():
                yield from inner._failing()

    def _with(self, **changed: Any) -> Message:
        copy = object.__new__(Message)
        copy._set(**{**{one.name: getattr(self, one.name) for one in fields(self)}, **changed})
        return copy

    def _set(self, **attributes: Any) -> None:
        for name, value in attributes.items():
            object.__setattr__(self, name, value)


def verbatim(text: str) -> Message:
    """Return a message for text that comes from elsewhere and stays as it is."""
    return Message("{text}", text=text)


def in_a_row(messages: Iterable[Message]) -> Message:
    """Return one message that says several, one after the other."""
    return Message("{sentences}", sentences=tuple(messages))


def _most_urgent(faults: Iterable[Fault]) -> Optional[Fault]:
    return max(faults, key=lambda one: (one.may_move, one.gravity), default=None)


def _value(value: Any) -> Value:
    if isinstance(value, (str, int, float, Message)):
        return value
    if isinstance(value, tuple) and all(isinstance(one, Message) for one in value):
        return value
    try:
        # Of numpy's numbers the Python number; arrays of several have none.
        number = value.item()
    except (AttributeError, ValueError, TypeError):
        number = None
    return number if isinstance(number, (int, float)) else str(value)
