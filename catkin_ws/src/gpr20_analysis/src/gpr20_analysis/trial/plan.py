"""The plan of a trial: what everybody may know beforehand, and a promise of the truth.

The truth is the table of targets, which stays with those who buried them. The plan holds the
SHA-256 of a random salt and the table behind it. Whoever has the plan cannot guess a small table
from that, nor the number of targets; whoever has the table cannot change it afterwards.
"""

from __future__ import annotations

import hashlib
import re
import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Tuple

from gpr20_analysis import __version__, faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.trial import hashed_file
from gpr20_analysis.trial.ground import Lane, Target, lane_of, read_targets
from gpr20_analysis.trial.tables import Row
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_survey.files.durable_files import write_new_file
from gpr20_survey.files.regular_file import read_regular

FORMAT = "gpr20-trial-plan/1"
SALT = ".salt"
_SALT_CONTENT = re.compile(rb"[0-9a-f]{64}\n")


@dataclass(frozen=True)
class Plan:
    """What is agreed before anybody measures."""

    halo_m: float  # a candidate within it of a target's centre finds the target [m]
    strata: Tuple[str, ...]  # columns of the tables by which the score is divided
    detection: float  # probability of detection that the trial is to show
    with_doubtful: bool  # whether doubtful candidates count; else only in the curves
    notes: str
    truth_known_by: Tuple[str, ...]
    lanes: Mapping[str, Lane]
    truth_sha256: str  # of salt and truth
    made: str  # ISO 8601
    software: str = __version__
    sha256: str = ""  # of the file; empty before it is written

    def __post_init__(self) -> None:
        number_between(Message("halo radius"), self.halo_m, 0.01, 10.0, "m")
        number_between(Message("probability of detection"), self.detection, 0.01, 0.9999)

    def encode(self) -> bytes:
        """Return the content of its file."""
        values = {"format": FORMAT, **vars(self)}
        values["lanes"] = [dict(one.row.cells) for one in self.lanes.values()]
        del values[hashed_file.OWN]
        return hashed_file.encode(values)

    def lane(self, name: str) -> Lane:
        """Return a lane.

        Raises:
            AnalysisError: The plan has no lane of this name.
        """
        if name not in self.lanes:
            raise AnalysisError(
                Message(
                    "the plan has no lane {lane}; it has {lanes}",
                    lane=repr(name[:64]),
                    lanes=", ".join(self.lanes),
                )
            )
        return self.lanes[name]


def salt_of(truth: Path) -> bytes:
    """Return the salt of a truth, which is in a file beside it; one is made if there is none.

    Raises:
        OSError: The disk refused.
    """
    path = truth.with_name(truth.name + SALT)
    if not path.exists():
        write_new_file(path, f"{secrets.token_hex(32)}\n".encode("ascii"))
    return read_regular(path)


def promise_of(salt: bytes, truth: bytes) -> str:
    """Return what the plan holds of the truth, as `cat SALT TRUTH | sha256sum` prints it."""
    return hashlib.sha256(salt + truth).hexdigest()


def read_plan(path: Path) -> Plan:
    """Return a plan.

    Raises:
        UnreadableFileError: It was changed, or is no plan.
        OSError: It cannot be read.
    """
    with hashed_file.decoded(path, FORMAT, Plan) as values:
        cells = [{str(key): str(one[key]) for key in one} for one in values.pop("lanes")]
        rows = [Row(path.name, 0, one) for one in cells]
        lanes = {row.text("lane"): lane_of(row) for row in rows}
        lists: Dict[str, Any] = {
            name: tuple(map(str, values.pop(name))) for name in ("strata", "truth_known_by")
        }
        return Plan(**values, **lists, lanes=lanes)


def read_truth(path: Path, plan: Plan) -> List[Target]:
    """Return the targets, if truth and salt are those that the plan promises.

    Raises:
        UnreadableFileError: One of them was changed.
        OSError: One of them cannot be read.
    """
    salt, truth = read_regular(path.with_name(path.name + SALT)), read_regular(path)
    if not _SALT_CONTENT.fullmatch(salt) or promise_of(salt, truth) != plan.truth_sha256:
        raise UnreadableFileError(
            Message(
                "{file} and its salt are not those of the plan: one of them was changed, or is of "
                "another trial",
                file=path.name,
            ),
            fault=faults.FILE_CHANGED,
        )
    return read_targets(truth, path.name, plan.lanes)
