"""Sentences for people: about a survey, in the attributes of its Dataset, and about failures.

Attributes `missing`, `faults`, `doubts`, `decisions` and `notes` are lists of English sentences.
Attribute `messages` holds the template and values of each, as JSON, so that it can be shown in
another language.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence

from gpr20_analysis import errors
from gpr20_analysis.errors import library_missing
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import ASKED_FOR, DISK_REFUSES, NOT_ALLOWED
from gpr20_common.message import BETWEEN_SENTENCES, Message, in_a_row, received_message
from gpr20_survey.faults import NOT_SIGNED

# The command line needs this module before it knows which libraries a command needs.
if TYPE_CHECKING:
    import xarray as xr

MISSING, FAULTS, DOUBTS, DECISIONS, NOTES = "missing", "faults", "doubts", "decisions", "notes"
LABELS = {
    MISSING: Message("NO DATA: {sentence}", sentence=""),
    FAULTS: Message("DAMAGED: {sentence}", sentence=""),
    DOUBTS: Message("DOUBTED: {sentence}", sentence=""),
    DECISIONS: Message("decided: {sentence}", sentence=""),
    NOTES: Message("note: {sentence}", sentence=""),
}
LIST_ATTRIBUTES = tuple(LABELS)
"""Attributes that are lists of sentences."""
MESSAGES = "messages"
ENGLISH = Catalogue()
EXTRAS = {"matplotlib": "plots"}
"""Optional libraries that whole commands need, and the extra of each."""
EXPECTED = (Gpr20Error, OSError, MemoryError, ModuleNotFoundError)
"""Errors whose message is sufficient; all others are program errors."""
TRACEBACK = "GPR20_TRACEBACK"
"""Environment variable: if set, a program error prints its traceback."""
STEP_IS_SAID = frozenset(
    one.code
    for one in (
        *(NOT_ALLOWED, ASKED_FOR, errors.INPUT, errors.STEPS, errors.TOO_LARGE),
        *(errors.NO_ROS, errors.ROBOT_RUNS, errors.PROGRAM, NOT_SIGNED),
    )
)
"""Codes whose remedy says in general what each of their sentences says exactly."""


def json_fields(message: Message) -> Dict[str, Any]:
    """Return a message as the outputs `--json` have it: the names of an answer of a service."""
    return {"message": str(message), "fault": message.record()}


def sentences_of(data: xr.Dataset, name: str) -> List[Message]:
    """Return the sentences of an attribute, such as `notes`.

    A sentence without a template, such as one from an older file, stays in English.
    """
    recorded = _recorded(data.attrs)
    return [received_message(str(one), recorded.get(one)) for one in data.attrs.get(name, [])]


def with_sentences(attributes: Mapping[str, Any], **lists: Iterable[Message]) -> Dict[str, Any]:
    """Return attributes in which some lists of sentences are replaced."""
    changed = dict(attributes)
    recorded = _recorded(changed)
    for name, messages in lists.items():
        sentences = [(str(one), one.record()) for one in messages]
        changed[name] = [text for text, _ in sentences]
        recorded.update(sentences)
    if recorded:
        changed[MESSAGES] = json.dumps(recorded)
    return changed


def labelled(name: str, sentence: Message) -> Message:
    """Return a sentence of one of the lists with the word that says which list it is of."""
    return LABELS[name].with_values({"sentence": sentence})


def sentence_of(data: xr.Dataset, name: str) -> Optional[Message]:
    """Return the sentence of an attribute that is one sentence; None if it is not there."""
    if name not in data.attrs:
        return None
    recorded = _recorded(data.attrs)
    text = str(data.attrs[name])
    return received_message(text, recorded.get(text))


def with_sentence(attributes: Mapping[str, Any], name: str, message: Message) -> Dict[str, Any]:
    """Return attributes with one that is a sentence."""
    recorded = _recorded(attributes)
    recorded[str(message)] = message.record()
    return {**attributes, name: str(message), MESSAGES: json.dumps(recorded)}


def with_notes(data: xr.Dataset, notes: Sequence[Message]) -> Dict[str, Any]:
    """Return the attributes of a Dataset with notes added to those that it has."""
    return with_sentences(data.attrs, notes=[*sentences_of(data, NOTES), *notes])


def with_doubts(data: xr.Dataset, *doubts: Message) -> xr.Dataset:
    """Return a Dataset with doubts added to those that it has."""
    if not doubts:
        return data
    found = {str(one): one for one in (*sentences_of(data, DOUBTS), *doubts)}
    return data.assign_attrs(with_sentences(data.attrs, doubts=found.values()))


def kept_doubts(doubts: Iterable[Message]) -> List[str]:
    """Return doubts as files of other formats hold them: a line for each, its code first."""
    return [f"{one.fault_code} {' '.join(str(one).split())}" for one in doubts]


def carried_doubts(values: Mapping[str, Any]) -> List[Message]:
    """Return the doubts that a file of another format holds under `doubts`."""
    lines = (line.partition(" ") for line in str(values.get(DOUBTS, "")).splitlines())
    return [received_message(text, {"code": code, "may_move": False}) for code, _, text in lines]


def with_decisions(data: xr.Dataset, *decisions: Message) -> xr.Dataset:
    """Return imported data with what was decided where the source says nothing."""
    found = [*sentences_of(data, DECISIONS), *decisions]
    return data.assign_attrs(with_sentences(data.attrs, decisions=found))


def first_of(messages: Sequence[Message], most: int) -> Message:
    """Return the first few messages as one, with the number of the others."""
    return in_a_row(limited(messages, most))


def limited(messages: Sequence[Message], most: int) -> List[Message]:
    """Return the first few messages, and one more with the number of the others."""
    others = len(messages) - most
    more = [Message("and {count} more", count=others)] if others > 0 else []
    return [*messages[:most], *more]


def shown(message: Message, catalogue: Catalogue = ENGLISH) -> str:
    """Return a message in the language of a catalogue, with its details in brackets."""
    details = BETWEEN_SENTENCES.join(message.all_details)
    sentence = catalogue.text(message)
    return f"{sentence} ({details})" if details else sentence


def message_of(error: BaseException, command: str) -> Message:
    """Return what went wrong.

    Args:
        error: Ended the command.
        command: What was called, such as "gpr20 info x".
    """
    file = error.filename if isinstance(error, OSError) else None
    if isinstance(error, Gpr20Error):
        reason = error.message
    elif isinstance(error, KeyboardInterrupt):
        return Message("interrupted; no partial output is left").with_fault(ASKED_FOR)
    elif isinstance(error, ModuleNotFoundError):
        name = error.name or ""
        missing = library_missing(name, EXTRAS.get(name.split(".")[0], ""))
        return missing.with_fault(errors.STEPS)
    elif isinstance(error, MemoryError):
        message = Message("not enough memory; use fewer samples", details=error)
        return message.with_fault(errors.TOO_LARGE)
    elif isinstance(error, OSError):
        reason = os_reason(error)
        reason = reason if reason.cause else reason.with_fault(DISK_REFUSES)
    else:
        return Message(
            "program error {error}; please report it with the output of {command}",
            error=f"{type(error).__name__}: {error}",
            command=f"{TRACEBACK}=1 {command}",
        ).with_fault(errors.PROGRAM)
    return Message("{file}: {reason}", file=file, reason=reason) if file else reason


def first_steps(message: Message) -> List[Message]:
    """Return what to do first; nothing if the message says it, or if that is not known."""
    cause = message.cause
    if cause is None or cause.remedy is None or cause.code in STEP_IS_SAID:
        return []
    return [Message("First: {remedy}", remedy=cause.remedy)]


def _recorded(attributes: Mapping[str, Any]) -> Dict[str, Any]:
    # A file without checksum may hold anything; without templates the sentences stay English.
    try:
        recorded = json.loads(attributes.get(MESSAGES, "{}"))
    except (ValueError, TypeError, RecursionError):
        return {}
    return recorded if isinstance(recorded, dict) else {}
