"""The ground of a trial: tables of lanes and targets, the area outside all halos, and strata.

Tables are CSV in UTF-8. Commas separate the cells, or semicolons where the decimals have a comma.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_common.terminal_text import is_shown

LEAST_M, MOST_M, MOST_DEPTH_M = 0.01, 1000.0, 10.0
PLACE = (-MOST_M, MOST_M)
LANE_COLUMNS = {"lane": None, **dict.fromkeys(("x_min_m", "x_max_m", "y_min_m", "y_max_m"), PLACE)}
TARGET_COLUMNS = {
    **{"target": None, "lane": None, "x_m": PLACE, "y_m": PLACE},
    **{"depth_m": (0.0, MOST_DEPTH_M), "type": None},
}
SLICES = 20_000
MOST_CHARACTERS = 200
Place = Tuple[float, float]
Row = Dict[str, Any]
Limits = Tuple[float, float]
_NUMBER = re.compile(r"[-+]?[0-9]*[.,]?[0-9]+(e[-+]?[0-9]{1,3})?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True)
class Lane:
    """A rectangle of ground, in the coordinates of the survey that is made on it."""

    notes: Mapping[str, str]  # other columns, such as the soil, by which targets may be divided
    name: str
    x_min_m: float
    x_max_m: float
    y_min_m: float
    y_max_m: float

    def __post_init__(self) -> None:
        for axis in "xy":
            low_m, high_m = getattr(self, f"{axis}_min_m"), getattr(self, f"{axis}_max_m")
            number_between(f"{self.name}: {axis}_min_m", low_m, *PLACE, "m")
            number_between(f"{self.name}: {axis}_max_m", high_m, low_m + LEAST_M, MOST_M, "m")

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
class Target:
    """An object that was buried for the trial."""

    name: str
    lane: str
    place_m: Place  # its centre [m]
    row: Mapping[str, Any]  # all columns


@dataclass(frozen=True)
class Group:
    """Targets that are counted together, and the lanes whose false alarms go with them."""

    name: str  # such as "type PMN"; empty: all
    targets: List[str]
    lanes: List[str]


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


def read_lanes(content: bytes, file: str) -> Dict[str, Lane]:
    """Return the lanes of a table by their names."""
    rows = read_table(content, file, LANE_COLUMNS)
    lanes = [Lane(row, *map(row.pop, LANE_COLUMNS)) for row in rows]
    return {one.name: one for one in lanes}


def read_targets(
    content: bytes, file: str, lanes: Mapping[str, Lane], strata: Sequence[str] = ()
) -> List[Target]:
    """Return the targets of a table, which has the strata that the lanes do not have."""
    columns: Dict[str, Any] = dict(TARGET_COLUMNS)
    for one in strata:
        if not any(one in lane.notes for lane in lanes.values()):
            columns.setdefault(one, None)
    targets = []
    for row in read_table(content, file, columns):
        place_m = row["x_m"], row["y_m"]
        if row["lane"] not in lanes or not lanes[row["lane"]].contains(place_m):
            outside = Message(
                "{file}: the place of target {target} is not in its lane, {lane}; lanes: {lanes}",
                **{"file": file, "target": row["target"], "lane": row["lane"]},
                lanes=", ".join(lanes),
            )
            raise UnreadableFileError(outside, fault=faults.INPUT)
        targets.append(Target(row["target"], row["lane"], place_m, row))
    return targets


def groups_of(
    strata: Sequence[str], targets: Sequence[Target], lanes: Mapping[str, Lane]
) -> List[Group]:
    """Return all targets, then those of each value of each column of the lanes or targets."""
    groups = [Group("", [one.name for one in targets], list(lanes))]
    for column in strata:
        of_lanes = {name: one.notes[column] for name, one in lanes.items() if column in one.notes}
        values = [of_lanes.get(one.lane) if of_lanes else one.row[column] for one in targets]
        for value in sorted({*values, *of_lanes.values()}, key=str):
            names = [one.name for one, own in zip(targets, values) if own == value]
            # A value of a lane limits the false alarms, one of a target does not.
            near = [one for one in lanes if not of_lanes or of_lanes.get(one) == value]
            groups.append(Group(f"{column} {value}", names, near))
    return groups
