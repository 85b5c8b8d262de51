"""What people add to the next survey, and the names of the surveys after it."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any, Dict, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.fields import PEOPLE
from gpr20_survey.plan.annotation import EMPTY, MAX_NAME_CHARACTERS, Annotation

# Of a text in a sheet, which has no room for more.
LONGEST_SHOWN = 30
_NUMBER_AT_END = re.compile(r"([0-9]{1,9})$", re.ASCII)


def annotation_texts(annotation: Annotation) -> Dict[str, str]:
    """Return the text of each field."""
    return {one.name: one.kind.write(getattr(annotation, one.name)) for one in PEOPLE}


def check_annotation(
    texts: Mapping[str, str],
) -> Tuple[Optional[Annotation], Dict[str, Message]]:
    """Return what the texts say, None if one is wrong, and what is wrong by its field."""
    values: Dict[str, Any] = {}
    problems: Dict[str, Message] = {}
    for spec in PEOPLE:
        try:
            values[spec.name] = spec.kind.read(texts[spec.name])
        except InvalidValueError as error:
            problems[spec.name] = error.message
    return None if problems else Annotation(**values), problems


def overwritten(before: Annotation, after: Annotation) -> Tuple[Tuple[Message, Message], ...]:
    """Return what changes, with the old and the new text of each field."""
    old, new = annotation_texts(before), annotation_texts(after)
    return tuple(
        (one.title, verbatim(" → ".join(_where_they_differ(old[one.name], new[one.name]))))
        for one in PEOPLE
        if old[one.name] != new[one.name]
    )


def _where_they_differ(old: str, new: str) -> Tuple[str, str]:
    """Return both texts, shortened so that their first difference is seen."""
    same = 0
    while same < min(len(old), len(new)) and old[same] == new[same]:
        same += 1
    if same < LONGEST_SHOWN - 2:
        return shortened(old), shortened(new)
    start = same - LONGEST_SHOWN // 3
    return shortened("…" + old[start:]), shortened("…" + new[start:])


def replaces_text(before: Annotation, after: Annotation) -> bool:
    """Return whether a text that somebody wrote is changed, not only an empty field filled."""
    old, new = annotation_texts(before), annotation_texts(after)
    return any(text and new[name] != text for name, text in old.items())


def shortened(text: str) -> str:
    """Return as much of a text as a sheet has room for, as one line; a dash if it is empty."""
    line = " ".join(text.split()) or "—"
    return line if len(line) <= LONGEST_SHOWN else line[: LONGEST_SHOWN - 1] + "…"


def first_name(site: str) -> str:
    """Return the name of the first survey at a site; empty if the site has no name."""
    return _joined(site.strip(), " 1") if site.strip() else ""


def next_name(name: str) -> str:
    """Return the name of the survey after one: "El Carmen 3" follows "El Carmen 2".

    The number keeps its leading zeros. A name without a number gets a 2; no name stays none.
    """
    if not name:
        return ""
    found = _NUMBER_AT_END.search(name)
    if found is None:
        return _joined(name, " 2")
    digits = found.group(1)
    return _joined(name[: found.start()], str(int(digits) + 1).zfill(len(digits)))


def _joined(before: str, after: str) -> str:
    return before[: MAX_NAME_CHARACTERS - len(after)] + after


class NextAnnotation:
    """Operator and site stay for the surveys that follow, and their names are numbered.

    Notes and position are for one survey.
    """

    def __init__(self) -> None:
        self.value = EMPTY

    def take_defaults(self, defaults: Annotation) -> None:
        """Fill the empty fields with those of the robot."""
        self.take(self.value.with_defaults(defaults))

    def take(self, annotation: Annotation) -> None:
        """Take over what the operator wrote, with a name if site is new and the name is not."""
        former, self.value = self.value, annotation
        if annotation.site != former.site and annotation.name in ("", first_name(former.site)):
            self.value = replace(annotation, name=first_name(annotation.site))

    def note_started(self) -> None:
        """Note that a survey has started with this annotation."""
        named = next_name(self.value.name)
        self.value = replace(self.value, name=named, notes="", position=None)
