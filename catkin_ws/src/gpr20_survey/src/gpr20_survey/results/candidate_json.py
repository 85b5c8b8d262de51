"""A list of candidates as the JSON that `gpr20 candidates --json` prints, and back."""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict
from typing import Any, Dict, List, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.sent_message import received_message
from gpr20_survey.no_clearance import NO_CLEARANCE, SIMULATED
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.candidates import Candidate, CandidateList, flag_of

FORMAT = "gpr20-candidates/2"
CANDIDATE_ID = re.compile(r"C[0-9]{2,7}")


def json_text(found: CandidateList) -> str:
    """Return a list as JSON."""
    record = {
        **list_record(found),
        "candidates": [candidate_record(one, found) for one in found.candidates],
    }
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False)


def list_record(found: CandidateList) -> Dict[str, Any]:
    """Return what is said about the whole list."""
    return {
        "format": FORMAT,
        "warning": str(NO_CLEARANCE),
        "simulated": found.simulated,
        **({"simulated_warning": str(SIMULATED)} if found.simulated else {}),
        "survey_id": found.survey_id,
        "method": found.method,
        "permittivity": found.permittivity,
        "permittivity_source": found.permittivity_source,
        "permittivity_lowest": found.permittivity_range[0],
        "permittivity_highest": found.permittivity_range[1],
        "area_m2": found.area_m2,
        "false_alarms_per_m2": _or_none(found.false_alarms_per_m2),
        "false_alarms_lowest": _or_none(found.false_alarms_range[0]),
        "false_alarms_highest": _or_none(found.false_alarms_range[1]),
        "listed": len(found.candidates),
        "omitted": found.omitted,
        "omitted_primary": found.omitted_primary,
        "coordinates": "X, Y and depth in metres, in the survey's area",
        "position": asdict(found.position) if found.position else None,
        "notes": [str(note) for note in found.notes],
        # With template and fault, for other programs of the robot.
        "notes_json": [note.to_json() for note in found.notes],
    }


def candidate_record(candidate: Candidate, found: CandidateList) -> Dict[str, Any]:
    """Return the values of a candidate; None for what is not known."""
    values = asdict(candidate)
    values["flags"] = [flag.value for flag in candidate.flags]
    values["doubtful"] = candidate.is_doubtful
    values["rotations_deg"] = [None if _is_nan(one) else one for one in candidate.rotations_deg]
    values["longitude_deg"], values["latitude_deg"] = (
        found.position.on_earth(candidate.x_m, candidate.y_m) if found.position else (None, None)
    )
    return {name: None if _is_nan(value) else value for name, value in values.items()}


def list_from(text: str, survey_id: Optional[str] = None) -> CandidateList:
    """Return the list that a command printed.

    Args:
        text: What it printed.
        survey_id: The survey that it was asked about; None: any.

    Raises:
        InvalidValueError: Something is missing, or has another type, format or survey.
    """
    try:
        found = _list_of(json.loads(text))
        _check(survey_id is None or found.survey_id == survey_id, "survey_id")
        return found
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        message = Message("the list of candidates is not complete or not valid", details=error)
        raise InvalidValueError(message) from error


def _list_of(values: Any) -> CandidateList:
    _check(isinstance(values, dict) and values["format"] == FORMAT, "format")
    # A list without it is of another kind.
    _check(bool(_text(values["warning"])), "warning")
    _check(isinstance(values["simulated"], bool), "simulated")
    candidates = tuple(_candidate(one) for one in _list(values["candidates"]))
    _check(_count(values["listed"]) == len(candidates), "listed")
    _check(len({one.id for one in candidates}) == len(candidates), "id")
    _check(_count(values["omitted_primary"]) <= _count(values["omitted"]), "omitted_primary")
    return CandidateList(
        survey_id=_text(values["survey_id"]),
        simulated=values["simulated"],
        method=_text(values["method"]),
        permittivity=_number(values["permittivity"], 1.0),
        permittivity_range=(
            _number(values["permittivity_lowest"], 1.0),
            _number(values["permittivity_highest"], 1.0),
        ),
        area_m2=_number(values["area_m2"], 0.0),
        false_alarms_per_m2=_number_or_nan(values["false_alarms_per_m2"], 0.0),
        false_alarms_range=(
            _number_or_nan(values["false_alarms_lowest"], 0.0),
            _number_or_nan(values["false_alarms_highest"], 0.0),
        ),
        omitted=values["omitted"],
        candidates=candidates,
        notes=_notes(_list(values["notes"]), _list(values.get("notes_json", []))),
        position=None if values["position"] is None else _position(values["position"]),
        omitted_primary=values["omitted_primary"],
        # Lists of earlier versions do not say it.
        permittivity_source=_text(values.get("permittivity_source", "")),
    )


def _notes(texts: List[Any], records: List[Any]) -> Tuple[Message, ...]:
    # Lists of earlier versions, and of other programs, have only the texts.
    records = records or [""] * len(texts)
    _check(len(texts) == len(records), "notes_json")
    return tuple(map(received_message, map(_text, texts), map(_text, records)))


def _candidate(values: Any) -> Candidate:
    _check(isinstance(values, dict), "candidate")
    _check(CANDIDATE_ID.fullmatch(_text(values["id"])) is not None, "id")
    ratio_db = values["polarization_ratio_db"]
    return Candidate(
        id=values["id"],
        x_m=_number(values["x_m"]),
        y_m=_number(values["y_m"]),
        depth_m=_number(values["depth_m"], 0.0),
        x_uncertainty_m=_number(values["x_uncertainty_m"], 0.0),
        y_uncertainty_m=_number(values["y_uncertainty_m"], 0.0),
        depth_uncertainty_m=_number(values["depth_uncertainty_m"], 0.0),
        above_clutter_db=_number(values["above_clutter_db"]),
        false_alarms_per_m2=_number_or_nan(values["false_alarms_per_m2"], 0.0),
        rotations_deg=tuple(_number_or_nan(one) for one in _list(values["rotations_deg"])),
        polarization_ratio_db=None if ratio_db is None else _number(ratio_db),
        flags=tuple(flag_of(_text(one)) for one in _list(values["flags"])),
    )


def _position(values: Any) -> AreaPosition:
    _check(isinstance(values, dict), "position")
    return AreaPosition(
        _number(values["latitude_deg"], -90.0, 90.0),
        _number(values["longitude_deg"], -180.0, 180.0),
        _number(values["heading_deg"]),
    )


def _check(right: bool, name: str) -> None:
    if not right:
        raise ValueError(f"wrong {name}")


def _list(value: object) -> List[Any]:
    if not isinstance(value, list):
        raise ValueError(f"{value!r} is no list")
    return value


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is no text")
    return value


def _number(value: object, lowest: float = -math.inf, highest: float = math.inf) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{value!r} is no number")
    # Written so that NaN is refused too.
    if not (math.isfinite(value) and lowest <= value <= highest):
        raise ValueError(f"{value!r} is out of range")
    return float(value)


def _number_or_nan(value: object, lowest: float = -math.inf) -> float:
    return math.nan if value is None else _number(value, lowest)


def _or_none(value: float) -> Optional[float]:
    return None if math.isnan(value) else value


def _count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"{value!r} is no count")
    return value


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)
