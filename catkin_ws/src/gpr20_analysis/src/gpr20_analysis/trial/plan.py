"""The plan of a trial, which everybody has, the truth that it seals, and lists of candidates.

The plan is YAML. It holds the SHA-256 of the table of targets, which stays with those who buried
them until all lists are in: nobody can change it afterwards. Tables are CSV in UTF-8; commas
separate the cells, or semicolons where the decimals have a comma.
"""

from __future__ import annotations

import csv
import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Dict, List, Mapping, Sequence, Tuple, Type, TypeVar, Union

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.yaml_file import YamlFileError, parse_yaml
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.mid.codec import bounded, record_from
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.results.candidates import list_from

LEAST_M, MOST_M, MOST_DEPTH_M = 0.01, 1000.0, 10.0
CELLS = 1000
NUMBERS = ("x_m", "y_m", "depth_m")
Place = Tuple[float, float]
Record = TypeVar("Record")


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
            number_between(f"{axis}_min_m", low_m, -MOST_M, MOST_M, "m")
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
        """Return its area outside all circles [m2], by the middles of `CELLS` cells a side."""
        part = (np.arange(CELLS) + 0.5) / CELLS
        x_m = self.x_min_m + (self.x_max_m - self.x_min_m) * part
        y_m = self.y_min_m + (self.y_max_m - self.y_min_m) * part
        outside = np.ones((CELLS, CELLS), bool)
        for centre_x_m, centre_y_m in centres_m:
            outside &= np.hypot(x_m - centre_x_m, (y_m - centre_y_m)[:, None]) > radius_m
        return self.area_m2 * float(outside.mean())


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
    """An object that was buried for the trial: a row of the truth, which may have other columns."""

    target: str
    lane: str
    x_m: float = bounded(-MOST_M, MOST_M)  # of its centre [m]
    y_m: float = bounded(-MOST_M, MOST_M)
    depth_m: float = bounded(0.0, MOST_DEPTH_M)  # of its top [m]
    type: str = ""
    cells: Mapping[str, str] = field(default_factory=dict)  # all columns

    @property
    def place_m(self) -> Place:
        return self.x_m, self.y_m


@dataclass(frozen=True)
class Mark:
    """A candidate. Its level is that above the clutter, or minus its place in a table."""

    id: str
    x_m: float = bounded(-MOST_M, MOST_M)
    y_m: float = bounded(-MOST_M, MOST_M)
    level: float = 0.0
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
    of_lanes = {name for lane in plan.lanes.values() for name in lane.notes}
    needed = ("target", "lane", "x_m", "y_m", "depth_m", "type")
    own = [one for one in plan.strata if one not in of_lanes]
    targets = _read_table(Target, content, file, [*needed, *own])
    for one in targets:
        if one.lane not in plan.lanes or not plan.lanes[one.lane].contains(one.place_m):
            outside = Message(
                "{file}: the place of target {target} is not in its lane, {lane}; lanes: {lanes}",
                **{"file": file, "target": one.target, "lane": one.lane},
                lanes=", ".join(plan.lanes),
            )
            raise UnreadableFileError(outside, fault=faults.INPUT)
    return targets


def read_list(method: str, lane: str, path: Path, plan: Plan) -> MarkList:
    """Return a list: JSON of `gpr20 candidates`, or CSV of any method, the most certain first.

    What a CSV is of is not known, so it counts as all of its lane.
    """
    content = b"" if path.is_dir() else read_regular(path)  # a survey is no list
    if path.suffix == ".csv":
        rows = _read_table(Mark, content, path.name, ["id", "x_m", "y_m"])
        marks = tuple(replace(one, level=-at) for at, one in enumerate(rows))
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


def _read_table(
    kind: Type[Record], content: bytes, file: str, needed: Sequence[str]
) -> List[Record]:
    """Return the rows of a table; each names another thing in the first of the columns needed."""
    try:
        lines = content.decode("utf-8-sig").splitlines()
        comma = ";" if lines and ";" in lines[0] else ","
        reader = csv.DictReader(lines, delimiter=comma, strict=True, restval="")
        found = [(reader.line_num, cells) for cells in reader if any(cells.values())]
    except (UnicodeDecodeError, csv.Error) as error:
        other = Message("save {file} as CSV in UTF-8", file=file, details=error)
        raise UnreadableFileError(other, fault=faults.INPUT) from error
    heading, names = reader.fieldnames or [], ", ".join(needed)
    if not set(needed) <= set(heading) or len(set(heading)) < len(heading):
        wanted = Message("the heading must name each column once, among them {names}", names=names)
        raise _refused(f"{file}, line 1", wanted)
    records: Dict[str, Record] = {}
    for line, cells in found:
        place, name = f"{file}, line {line}", cells[needed[0]]
        if None in cells or not all(cells[column] for column in needed):
            raise _refused(
                place, Message("it needs a cell for each column, as {names}", names=names)
            )
        if name in records:
            raise _refused(place, Message("there are two rows of {name}", name=repr(name)))
        values = {key: _number(cells[key]) if key in NUMBERS else cells[key] for key in needed}
        records[name] = record_from(kind, {**values, "cells": cells}, place, others=True)
    return list(records.values())


def _number(cell: str) -> Union[float, str]:
    """Return a number, which may have a decimal comma; what is none stays text."""
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return cell


def _refused(place: str, reason: Message) -> UnreadableFileError:
    message = Message("{place}: {reason}", place=place, reason=reason)
    return UnreadableFileError(message, fault=faults.INPUT)
