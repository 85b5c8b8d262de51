"""A list of candidates as the JSON that `gpr20 candidates --json` prints, and back."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from typing import Any, Dict, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_common.sent_message import received_message
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED, Candidate, CandidateList

FORMAT = "gpr20-candidates/1"
"""Another flag, or another key that must be there, is another format."""


@dataclass(frozen=True)
class _Head:
    """What the JSON says beside the fields of the list.

    Attributes:
        warning: What has none is a list of another kind.
        notes_json: The notes with template and fault; lists of other programs have only texts.
    """

    format: str
    warning: str = field(metadata={"min_length": 1})
    listed: int
    notes: Tuple[str, ...]
    notes_json: Tuple[str, ...] = ()


def json_text(found: CandidateList) -> str:
    """Return a list as JSON."""
    record = {
        **list_record(found),
        "candidates": [candidate_record(one, found) for one in found.candidates],
    }
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False)


def list_record(found: CandidateList) -> Dict[str, Any]:
    """Return what is said about the whole list."""
    values = plain(replace(found, candidates=(), notes=()))
    del values["candidates"], values["length_m"]
    return {
        "format": FORMAT,
        "warning": str(NO_CLEARANCE),
        **({"simulated_warning": str(SIMULATED)} if found.simulated else {}),
        **values,
        "listed": len(found.candidates),
        "coordinates": "X, Y and depth in metres, in the survey's area",
        "notes": [str(note) for note in found.notes],
        # With template and fault, for other programs of the robot.
        "notes_json": [note.to_json() for note in found.notes],
    }


def candidate_record(candidate: Candidate, found: CandidateList) -> Dict[str, Any]:
    """Return the values of a candidate; None for what is not known."""
    place = found.position and found.position.on_earth(candidate.x_m, candidate.y_m)
    longitude_deg, latitude_deg = place or (None, None)
    return {
        **plain(candidate),
        "doubtful": candidate.is_doubtful,
        "longitude_deg": longitude_deg,
        "latitude_deg": latitude_deg,
    }


def list_from(text: str, survey_id: Optional[str] = None) -> CandidateList:
    """Return the list that a command printed.

    Args:
        text: What it printed.
        survey_id: The survey that it was asked about; None: any.

    Raises:
        InvalidValueError: Something is missing, or has another type, format or survey.
    """
    try:
        values = json.loads(text)
        head = record_from(_Head, values, "", others=True)
        found = record_from(CandidateList, {**values, "notes": []}, "", others=True)
        records = head.notes_json or [""] * len(head.notes)
        for name, right in {
            f"format {head.format}": head.format == FORMAT,
            "listed": head.listed == len(found.candidates),
            "id": len({one.id for one in found.candidates}) == len(found.candidates),
            "omitted_primary": found.omitted_primary <= found.omitted,
            "notes_json": len(head.notes) == len(records),
            "survey_id": survey_id in (None, found.survey_id),
        }.items():
            if not right:
                raise ValueError(f"wrong {name}")
    except (ValueError, RecursionError) as error:
        message = Message("the list of candidates is not complete or not valid", details=error)
        raise InvalidValueError(message) from error
    return replace(found, notes=tuple(map(received_message, head.notes, records)))
