"""The plan of a trial, which everybody has, the truth that it seals, and lists of candidates.

The plan is YAML. It holds the SHA-256 of the table of targets, which stays with those who buried
them until all lists are in: nobody can change it afterwards. Tables are CSV in UTF-8; commas
separate the cells, or semicolons where the decimals have a comma.
"""

from __future__ import annotations

import csv
import hashlib
import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.yaml_file import YamlFileError, parse_yaml
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import is_shown
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.results.candidates import list_from

LEAST_M, MOST_M, MOST_DEPTH_M = 0.01, 1000.0, 10.0
PLACE = (-MOST_M, MOST_M)
TARGET_COLUMNS = {
    **{"target": None, "lane": None, "x_m": PLACE, "y_m": PLACE},
    **{"depth_m": (0.0, MOST_DEPTH_M), "type": None},
}
MARK_COLUMNS = {"id": None, "x_m": PLACE, "y_m": PLACE}
SLICES = 20_000
MOST_CHARACTERS = 200
Place = Tuple[float, float]
Row = Dict[str, Any]
Limits = Tuple[float, float]
_NUMBER = re.compile(r"[-+]?[0-9]*[.,]?[0-9]+(e[-+]?[0-9]{1,3})?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class Lane:
    """A rectangle of ground, in the coordinates of the survey that is made on it."""

    x_min_m: float
    x_max_m: float
    y_min_m: float
    y_max_m: float
    notes: Mapping[str, str] = field(default_factory=dict)
    """What targets may be divided by, such as the soil."""

    def __post_init__(self) -> None:
        for axis in "xy":
            low_m, high_m = getattr(self, f"{axis}_min_m"), getattr(self, f"{axis}_max_m")
            number_between(f"{axis}_min_m", low_m, *PLACE, "m")
            number_between(f"{axis}_max_m", high_m, low_m + LEAST_M, MOST_M, "m")

    @property
    def area_m2(self) -> float:
        """Its area [m2]."""
        return (self.x_max_m - self.x_min_m) * (self.y_max_m - self.y_min_m)

    def contains(self, place_m: Place) -> bool:
        """Return whether a place is in it or on its edge."""
        x_m, y_m = place_m
        return self.x_min_m <= x_m <= self.x_max_m and self.y_min_m <= y_m <= self.y_max_m

    def area_outside(self, centres_m: Sequence[Place], radius_m: float) -> float:
        """Return its area outside all circles [m2], which may overlap and leave it.

        It is cut into slices along X; the error is about 1e-6 of the area of the lane.
        """
        width_m = (self.x_max_m - self.x_min_m) / SLICES
        x_m = self.x_min_m + width_m * (np.arange(SLICES) + 0.5)
        centres = np.reshape(np.asarray(centres_m, np.float64), (-1, 2))
        half = np.sqrt(np.maximum(radius_m**2 - (x_m - centres[:, :1]) ** 2, 0.0))
        low = np.clip(centres[:, 1:] - half, self.y_min_m, self.y_max_m)
        high = np.clip(centres[:, 1:] + half, self.y_min_m, self.y_max_m)
        order = np.argsort(low, axis=0)
        low, high = (np.take_along_axis(one, order, 0) for one in (low, high))
        # What is below the highest end so far is counted already.
        low[1:] = np.maximum(low[1:], np.maximum.accumulate(high, axis=0)[:-1])
        covered_m2 = width_m * float(np.maximum(high - low, 0.0).sum())
        return max(self.area_m2 - covered_m2, 0.0)


@dataclass(frozen=True)
class Plan:
    """What is agreed before anybody measures."""

    halo_m: float  # a candidate within it of a target's centre finds the target [m]
    truth_sha256: str  # of the table of targets
    lanes: Mapping[str, Lane]
    strata: Tuple[str, ...] = ()  # notes of lanes and columns of targets that divide the score

    def __post_init__(self) -> None:
        number_between(Message("halo radius"), self.halo_m, 0.01, 10.0, "m")


@dataclass(frozen=True)
class Target:
    """An object that was buried for the trial."""

    name: str
    lane: str
    place_m: Place  # its centre [m]
    row: Mapping[str, Any]  # all columns


@dataclass(frozen=True)
class Mark:
    """A candidate. Its level is that above the clutter, or minus its place in a table."""

    id: str
    x_m: float
    y_m: float
    level: float
    is_weaker: bool = False  # below the cut of its list

    @property
    def rank(self) -> Tuple[bool, float]:
        """What orders candidates: the most certain first, those below the cut last."""
        return (self.is_weaker, -self.level)


@dataclass(frozen=True)
class MarkList:
    """The candidates of one method in one lane."""

    method: str
    lane: str
    marks: Tuple[Mark, ...]
    area_m2: float  # surveyed [m2]
    simulated: bool = False


def read_plan(path: Path) -> Plan:
    """Return the plan of a trial."""
    try:
        return record_from(Plan, parse_yaml(read_regular(path)), path.name)
    except YamlFileError as error:
        other = Message("{file} is no plan of a trial: {reason}", file=path, reason=error.message)
        raise UnreadableFileError(other, fault=faults.INPUT) from error


def read_truth(path: Path, plan: Plan) -> List[Target]:
    """Return the targets; a table that is not the sealed one is refused."""
    content = read_regular(path)
    if hashlib.sha256(content).hexdigest() != plan.truth_sha256:
        changed = Message("{file} is not the table whose SHA-256 is in the plan", file=path)
        raise UnreadableFileError(changed, fault=faults.FILE_DAMAGED)
    return read_targets(content, path.name, plan)


def read_targets(content: bytes, file: str, plan: Plan) -> List[Target]:
    """Return the targets of a table, which has the strata that the lanes do not have."""
    columns: Dict[str, Any] = dict(TARGET_COLUMNS)
    for one in plan.strata:
        if not any(one in lane.notes for lane in plan.lanes.values()):
            columns.setdefault(one, None)
    targets = []
    for row in read_table(content, file, columns):
        place_m = row["x_m"], row["y_m"]
        if row["lane"] not in plan.lanes or not plan.lanes[row["lane"]].contains(place_m):
            outside = Message(
                "{file}: the place of target {target} is not in its lane, {lane}; lanes: {lanes}",
                **{"file": file, "target": row["target"], "lane": row["lane"]},
                lanes=", ".join(plan.lanes),
            )
            raise UnreadableFileError(outside, fault=faults.INPUT)
        targets.append(Target(row["target"], row["lane"], place_m, row))
    return targets


def read_list(method: str, lane: str, path: Path, plan: Plan) -> MarkList:
    """Return a list: JSON of `gpr20 candidates`, or CSV of any method, the most certain first.

    What a CSV is of is not known, so it counts as all of its lane.
    """
    content = b"" if path.is_dir() else read_regular(path)  # a survey is no list
    if path.suffix == ".csv":
        rows = read_table(content, path.name, MARK_COLUMNS)
        marks = tuple(Mark(one["id"], one["x_m"], one["y_m"], -at) for at, one in enumerate(rows))
        whole = plan.lanes[lane].area_m2 if lane in plan.lanes else 0.0
        return MarkList(method, lane, marks, whole)
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
    return MarkList(method, lane, marks, found.area_m2, found.simulated)


def read_table(content: bytes, file: str, columns: Mapping[str, Optional[Limits]]) -> List[Row]:
    """Return the rows of a table; its other columns may hold any text.

    Args:
        content: The CSV.
        file: Its name, for messages.
        columns: Those that it must have, with the limits of a number, or None for a text. Each row
            names another thing in the first of them.
    """
    try:
        lines = content.decode("utf-8-sig").splitlines()
        comma = ";" if lines and ";" in lines[0] else ","
        reader = csv.DictReader(lines, delimiter=comma, strict=True)
        found = [(reader.line_num, cells) for cells in reader if any(cells.values())]
    except (UnicodeDecodeError, csv.Error) as error:
        other = Message("save {file} as CSV in UTF-8", file=file, details=error)
        raise UnreadableFileError(other, fault=faults.INPUT) from error
    heading = reader.fieldnames or []
    if not set(columns) <= set(heading) or len(set(heading)) < len(heading):
        names = ", ".join(columns)
        wanted = Message("the heading must name each column once, among them {names}", names=names)
        raise _refused(file, 1, wanted)
    rows: Dict[str, Row] = {}
    for line, cells in found:
        row = _row(file, line, cells, columns)
        name = row[next(iter(columns))]
        if rows.setdefault(name, row) is not row:
            raise _refused(file, line, Message("there are two rows of {name}", name=repr(name)))
    return list(rows.values())


def _row(file: str, line: int, cells: Row, columns: Mapping[str, Optional[Limits]]) -> Row:
    if None in cells or None in cells.values():
        raise _refused(file, line, Message("it needs as many cells as the heading has"))
    row: Row = {column: cell.strip() for column, cell in cells.items()}
    for column, limits in columns.items():
        cell = row[column]
        if limits is None:
            is_right = 0 < len(cell) <= MOST_CHARACTERS and all(map(is_shown, cell))
        else:
            row[column] = float(cell.replace(",", ".")) if _NUMBER.fullmatch(cell) else math.nan
            is_right = limits[0] <= row[column] <= limits[1]
        if not is_right:
            allowed = "{:g} ... {:g}".format(*limits) if limits else Message("a text")
            refusal = Message(
                "{value} in column {column} is not allowed; write {allowed}",
                **{"value": repr(cell[:64]), "column": column, "allowed": allowed},
            )
            raise _refused(file, line, refusal)
    return row


def _refused(file: str, line: int, reason: Message) -> UnreadableFileError:
    message = Message("{file}, line {line}: {reason}", file=file, line=line, reason=reason)
    return UnreadableFileError(message, fault=faults.INPUT)
