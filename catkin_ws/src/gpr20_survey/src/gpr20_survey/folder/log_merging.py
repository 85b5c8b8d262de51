"""Making one log of the records that its forms hold, of which each has a right checksum."""

from __future__ import annotations

from typing import List, Mapping, Sequence, Tuple

from gpr20_survey.folder.log_record import NO_RECORD, Kind, LogRecord
from gpr20_survey.folder.manifest import LogHead

Records = Mapping[int, LogRecord]
"""The records of one form, by their numbers."""


def merged(forms: Sequence[Records], heads: Sequence[LogHead]) -> List[LogRecord]:
    """Return the record of each number that is right, and follows the one before it.

    Args:
        forms: The records of log.jsonl, of survey.json and of a recording.
        heads: Those that a manifest names.
    """
    numbers = sorted({number for form in forms for number in form})
    successors = {
        (number - 1, record.previous) for form in forms for number, record in form.items()
    }
    found: List[LogRecord] = []
    for number in numbers:
        candidates = [form[number] for form in forms if number in form]
        # One whose values were left out counts only if the record behind it names its checksum.
        confirmed = [
            one
            for one in candidates
            if one.values is not None or (number, one.sha256) in successors
        ]
        # Where forms contradict each other, the one that something else names is right.
        recorded = forms[-1].get(number)
        confirmed.sort(
            key=lambda one: (
                LogHead.of(one) not in heads,
                (number, one.sha256) not in successors,
                recorded is None or one.sha256 != recorded.sha256,
                one.values is None,
            )
        )
        fitting = [one for one in confirmed if _follows(found, one)]
        if fitting:
            found.append(fitting[0])
    return found


def _follows(found: Sequence[LogRecord], record: LogRecord) -> bool:
    if record.number == 0:
        return record.previous == NO_RECORD
    last = found[-1] if found else None
    # Behind a lost record nothing but its own checksum vouches for a record.
    return last is None or last.number < record.number - 1 or last.sha256 == record.previous


def contradicting(found: Sequence[LogRecord], forms: Sequence[Records]) -> Tuple[LogRecord, ...]:
    """Return the records that are right, and not of the log of the others.

    Args:
        found: The log.
        forms: As for `merged`.
    """
    used = {(one.number, one.sha256) for one in found}
    others = {
        (number, record.sha256): record
        for form in forms
        for number, record in form.items()
        # Nothing vouches for one without values.
        if (number, record.sha256) not in used and record.values is not None
    }
    return tuple(others[key] for key in sorted(others))


def lost_numbers(found: Sequence[LogRecord], end: int) -> List[int]:
    """Return the numbers of the records that are lost, and that no record names as lost.

    Args:
        found: The log.
        end: Number of the last record that there was.
    """
    present = {one.number for one in found}
    named = {
        number
        for one in found
        if one.kind == Kind.UNCONFIRMED.value and one.values is not None
        for number in one.values.get("lost", [])
    }
    last = max(end, found[-1].number if found else -1)
    return [number for number in range(last + 1) if number not in present | named]
