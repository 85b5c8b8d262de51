"""Sealed lists: what a method said of a lane, before the truth was opened."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

from gpr20_analysis import __version__
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.trial import hashed_file
from gpr20_analysis.trial.ground import MOST_M
from gpr20_analysis.trial.tables import Row, read_table
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.results.candidate_json import list_from

FORMAT = "gpr20-trial-seal/1"
COLUMNS = ("id", "x_m", "y_m")
SIMULATED = re.compile(rb"^# simulated: true\b", re.MULTILINE)  # as gpr20 candidates writes it
LEVEL, DOUBTFUL = "above_clutter_db", "doubtful"


@dataclass(frozen=True)
class Mark:
    """A candidate: its name in the list, its place [m], its level [dB], whether it is doubtful.

    The level is that above the clutter; of a list without levels, minus the place in the list.
    """

    id: str
    x_m: float
    y_m: float
    level: float
    doubtful: bool = False

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.x_m, self.y_m, self.level))):
            raise ValueError("a place or level is not finite")

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
    area_m2: Optional[float] = None  # surveyed area [m2]; None if the list does not say
    omitted: int = 0  # how many candidates the list left out
    plan_sha256: str = ""
    method: str = ""
    lane: str = ""
    operator: str = ""
    sealed: str = ""  # ISO 8601
    software: str = __version__
    sha256: str = ""  # of the file; empty before it is written

    def encode(self) -> bytes:
        """Return the content of its file."""
        values: Dict[str, Any] = {"format": FORMAT, **asdict(self)}
        del values[hashed_file.OWN]
        return hashed_file.encode(values)


def read_candidates(path: Path) -> Seal:
    """Return a list that is not sealed: JSON of `gpr20 candidates`, or CSV of any method.

    Raises:
        UnreadableFileError: It is damaged, or holds something else.
        OSError: It cannot be read.
    """
    content = b"" if path.is_dir() else read_regular(path)  # a survey is no list
    own = hashlib.sha256(content).hexdigest()
    if path.suffix == ".csv":
        rows = read_table(content, path.name, COLUMNS)
        marks = tuple(_mark(row, -float(at)) for at, row in enumerate(rows))
        return Seal(marks, own, simulated=SIMULATED.search(content) is not None)
    try:
        found = list_from(content.decode("utf-8"))
    except (UnicodeDecodeError, InvalidValueError) as error:
        raise UnreadableFileError(
            Message(
                "{file} is no list of candidates; write one with {command}",
                file=path.name,
                command="gpr20 candidates SURVEY -o LIST.json",
                details=error,
            )
        ) from error
    marks = tuple(
        Mark(one.id, one.x_m, one.y_m, one.above_clutter_db, one.is_doubtful)
        for one in found.candidates
    )
    return Seal(marks, own, found.survey_id, found.simulated, found.area_m2, found.omitted)


def read_seal(path: Path) -> Seal:
    """Return a sealed list.

    Raises:
        UnreadableFileError: It was changed, or is none.
        OSError: It cannot be read.
    """
    with hashed_file.decoded(path, FORMAT, Seal) as values:
        for one in values["marks"]:
            hashed_file.check_types(one, Mark)
        marks = tuple(Mark(**one) for one in values.pop("marks"))
        return Seal(marks, **values)


def _mark(row: Row, level: float) -> Mark:
    x_m, y_m = (row.number(one, -MOST_M, MOST_M) for one in COLUMNS[1:])
    if row.cells.get(LEVEL):
        level = row.number(LEVEL, -MOST_M, MOST_M)
    doubtful = bool(row.cells.get(DOUBTFUL)) and row.number(DOUBTFUL, 0.0, 1.0) > 0.0
    return Mark(row.text("id"), x_m, y_m, level, doubtful)
