"""The files of a trial: the plan, a promise of the truth, and sealed lists of candidates.

Plan and sealed lists are JSON with a SHA-256 of all else in them: no byte changes unseen. The truth
is the table of targets, which stays with those who buried them. The plan holds the SHA-256 of a
random salt and the table behind it. Whoever has the plan cannot guess a small table from that, nor
the number of targets; whoever has the table cannot change it afterwards.
"""

from __future__ import annotations

import hashlib
import re
import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Tuple

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.trial.ground import PLACE, Lane, Target, read_table, read_targets
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import record_from
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.durable_files import write_new_file
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder import survey_metadata
from gpr20_survey.results.candidates import list_from

PLAN, SEAL = "gpr20-trial-plan/1", "gpr20-trial-seal/1"
SALT = ".salt"
MARK_COLUMNS = {"id": None, "x_m": PLACE, "y_m": PLACE}
_SALT_CONTENT = re.compile(rb"[0-9a-f]{64}\n")


@dataclass(frozen=True)
class Plan:
    """What is agreed before anybody measures."""

    halo_m: float  # a candidate within it of a target's centre finds the target [m]
    strata: Tuple[str, ...]  # columns of the tables by which the score is divided
    lanes: Mapping[str, Lane]
    truth_sha256: str = ""  # of salt and truth
    made: str = ""  # ISO 8601
    sha256: str = ""  # of the file; empty before it is written

    def __post_init__(self) -> None:
        number_between(Message("halo radius"), self.halo_m, 0.01, 10.0, "m")


@dataclass(frozen=True)
class Mark:
    """A candidate. Its level is that above the clutter, or minus its place in a table."""

    id: str
    x_m: float
    y_m: float
    level: float
    doubtful: bool = False

    @property
    def rank(self) -> Tuple[bool, float]:
        """What orders candidates: the most certain first, those that are doubtful last."""
        return (self.doubtful, -self.level)


@dataclass(frozen=True)
class Seal:
    """A list of candidates in the coordinates of its survey, and what it was sealed for."""

    marks: Tuple[Mark, ...]
    list_sha256: str  # of the file of the list
    survey_id: str = ""  # empty if the list does not say
    simulated: bool = False
    area_m2: float = 0.0  # surveyed area [m2]; 0 if the list does not say
    plan_sha256: str = ""
    method: str = ""
    lane: str = ""
    operator: str = ""
    made: str = ""  # ISO 8601
    sha256: str = ""  # of the file; empty before it is written


def encode(form: str, values: Mapping[str, Any]) -> bytes:
    """Return the content of a file: a format, values, and the SHA-256 of both."""
    hashed = {"format": form, **values}
    hashed.pop("sha256", None)
    own = hashlib.sha256(survey_metadata.encode(hashed)).hexdigest()
    return survey_metadata.encode({**hashed, "sha256": own})


def read_plan(path: Path) -> Plan:
    """Return a plan; one that was changed is refused."""
    return record_from(Plan, _decoded(path, PLAN), path.name)


def read_seal(path: Path) -> Seal:
    """Return a sealed list; one that was changed is refused."""
    return record_from(Seal, _decoded(path, SEAL), path.name)


def _decoded(path: Path, form: str) -> Dict[str, Any]:
    content, most = read_regular(path), survey_metadata.MAX_FILE_BYTES
    try:
        values = survey_metadata.parse_object(content.decode("ascii"), path.name, most)
        if values.pop("format") != form or encode(form, values) != content:
            raise ValueError("another format or SHA-256")
        return values
    except (SurveyRefusedError, ValueError, KeyError) as error:
        changed = Message(
            "{file} was changed, or is no {form}", file=path, form=form, details=error
        )
        raise UnreadableFileError(changed, fault=faults.FILE_DAMAGED) from error


def salt_of(truth: Path) -> bytes:
    """Return the salt of a truth, which is in a file beside it; one is made if there is none."""
    path = truth.with_name(truth.name + SALT)
    if not path.exists():
        write_new_file(path, f"{secrets.token_hex(32)}\n".encode("ascii"))
    salt = read_regular(path)
    if not _SALT_CONTENT.fullmatch(salt):
        other = Message("{file} is not 64 hexadecimal digits and a line feed; delete it", file=path)
        raise UnreadableFileError(other, fault=faults.INPUT)
    return salt


def promise_of(salt: bytes, truth: bytes) -> str:
    """Return what the plan holds of the truth, as `cat SALT TRUTH | sha256sum` prints it."""
    return hashlib.sha256(salt + truth).hexdigest()


def read_truth(path: Path, plan: Plan) -> List[Target]:
    """Return the targets; a truth or salt that is not the promised one is refused."""
    salt, truth = read_regular(path.with_name(path.name + SALT)), read_regular(path)
    if not _SALT_CONTENT.fullmatch(salt) or promise_of(salt, truth) != plan.truth_sha256:
        changed = Message("{file} or its salt was changed, or is of another trial", file=path)
        raise UnreadableFileError(changed, fault=faults.FILE_DAMAGED)
    return read_targets(truth, path.name, plan.lanes, plan.strata)


def read_candidates(path: Path) -> Seal:
    """Return a list that is not sealed: JSON of `gpr20 candidates`, or CSV of any method."""
    content = b"" if path.is_dir() else read_regular(path)  # a survey is no list
    own = hashlib.sha256(content).hexdigest()
    if path.suffix == ".csv":
        rows = read_table(content, path.name, MARK_COLUMNS)
        unknown = [repr(one) for one in next(iter(rows), ()) if one not in MARK_COLUMNS]
        if unknown:
            only = Message(
                "{file} has columns {unknown}; keep only {names}, or give the .json of {command}",
                **{"file": path, "unknown": ", ".join(unknown), "names": ", ".join(MARK_COLUMNS)},
                command="gpr20 candidates",
            )
            raise UnreadableFileError(only, fault=faults.INPUT)
        marks = tuple(Mark(one["id"], one["x_m"], one["y_m"], -at) for at, one in enumerate(rows))
        return Seal(marks, own)
    try:
        found = list_from(content.decode("utf-8"))
    except (UnicodeDecodeError, InvalidValueError) as error:
        other = Message(
            "{file} is no list of candidates; write one with {command}",
            **{"file": path.name, "command": "gpr20 candidates SURVEY -o LIST.json"},
            details=error,
        )
        raise UnreadableFileError(other) from error
    marks = tuple(
        Mark(one.id, one.x_m, one.y_m, one.above_clutter_db, one.is_doubtful)
        for one in found.candidates
    )
    return Seal(marks, own, found.survey_id, found.simulated, found.area_m2)
