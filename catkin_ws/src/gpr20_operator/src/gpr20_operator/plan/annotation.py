"""What people add to the next survey, and the names of the surveys after it."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import takewhile
from typing import Dict, Mapping, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.fields import PEOPLE
from gpr20_survey.plan.annotation import EMPTY, MAX_NAME_CHARACTERS, Annotation

# Of a text in a sheet, which has no room for more.
LONGEST_SHOWN = 30
_NUMBER_AT_END = re.compile(r"([0-9]{1,9})$", re.ASCII)


def annotation_texts(annotation: Annotation) -> Dict[str, str]:
    """Return the text of each field."""
    return {one.name: one.kind.write(getattr(annotation, one.name)) for one in PEOPLE}


def annotation_from(texts: Mapping[str, str]) -> Annotation:
    """Return what the texts of all fields say.

    Raises:
        InvalidValueError: One is not allowed.
    """
    return Annotation(**{one.name: one.kind.read(texts[one.name]) for one in PEOPLE})


def overwritten(before: Annotation, after: Annotation) -> Tuple[Tuple[Message, Message], ...]:
    """Return what changes, with the old and the new text from where they differ."""
    rows = []
    texts = annotation_texts(before).values(), annotation_texts(after).values()
    for spec, old, new in zip(PEOPLE, *texts):
        same = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(old, new)))
        if old != new and same >= LONGEST_SHOWN - 2:
            old, new = (f"…{text[same - LONGEST_SHOWN // 3 :]}" for text in (old, new))
        if old != new:
            rows.append((spec.title, verbatim(f"{shortened(old)} → {shortened(new)}")))
    return tuple(rows)


def shortened(text: str) -> str:
    """Return as much of a text as a sheet has room for, as one line; a dash if it is empty."""
    line = " ".join(text.split()) or "—"
    return line if len(line) <= LONGEST_SHOWN else line[: LONGEST_SHOWN - 1] + "…"


def next_name(name: str) -> str:
    """Return the name of the survey after one: "El Carmen 3" follows "El Carmen 2".

    The number keeps its leading zeros. A name without a number gets a 2; no name stays none.
    """
    if not name:
        return ""
    found = _NUMBER_AT_END.search(name)
    digits = "" if found is None else found.group(1)
    number = str(int(digits) + 1).zfill(len(digits)) if digits else " 2"
    return name[: len(name) - len(digits)][: MAX_NAME_CHARACTERS - len(number)] + number


class NextAnnotation:
    """Operator and site stay for the surveys that follow, and their names are numbered.

    Notes and position are for one survey.
    """

    def __init__(self) -> None:
        self.value = EMPTY

    def take_defaults(self, defaults: Annotation) -> None:
        """Fill the empty fields with those of the robot."""
        self.value = self.value.with_defaults(defaults)

    def note_started(self) -> None:
        """Note that a survey has started with this annotation."""
        named = next_name(self.value.name)
        self.value = replace(self.value, name=named, notes="", position=None)
