"""The ground of a trial: lanes, targets, the area outside all halos, and strata."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from typing import Dict, List, Mapping, Sequence, Tuple

import numpy as np

from gpr20_analysis.trial.tables import Row, read_table
from gpr20_common.message import Message

MOST_M, MOST_DEPTH_M = 1000.0, 10.0
LANE_COLUMNS = ("lane", "x_min_m", "x_max_m", "y_min_m", "y_max_m")
TARGET_COLUMNS = ("target", "lane", "x_m", "y_m", "depth_m", "type")
SLICES, AT_ONCE = 20_000, 200
Place = Tuple[float, float]


@dataclass(frozen=True)
class Lane:
    """A rectangle of ground, in the coordinates of the survey that is made on it."""

    row: Row  # columns that are not read here are notes or strata, as the soil
    low_m: Place  # the corner with the lowest X and Y [m]
    high_m: Place  # the corner with the highest X and Y [m]

    @property
    def area_m2(self) -> float:
        """Its area [m2]."""
        return (self.high_m[0] - self.low_m[0]) * (self.high_m[1] - self.low_m[1])

    def contains(self, place_m: Place) -> bool:
        """Return whether a place is in it or on its edge."""
        (left, near), (right, far) = self.low_m, self.high_m
        return left <= place_m[0] <= right and near <= place_m[1] <= far

    def area_outside(self, centres_m: Sequence[Place], radius_m: float) -> float:
        """Return its area outside all circles [m2], which may overlap and leave it.

        It is cut into slices along X; the error is about 1e-6 of the area of the lane.
        """
        (left, near), (right, far) = self.low_m, self.high_m
        width_m = (right - left) / SLICES
        circles, covered_m2 = np.reshape(np.asarray(centres_m, np.float64), (-1, 1, 2)), 0.0
        for x_m in np.split(left + width_m * (np.arange(SLICES) + 0.5), SLICES // AT_ONCE):
            half = np.sqrt(np.maximum(radius_m**2 - (x_m - circles[..., 0]) ** 2, 0.0))
            low = np.clip(circles[..., 1] - half, near, far)
            high = np.clip(circles[..., 1] + half, near, far)
            order = np.argsort(low, axis=0)
            low, high = (np.take_along_axis(one, order, 0) for one in (low, high))
            # What is below the highest end so far is counted already.
            low[1:] = np.maximum(low[1:], np.maximum.accumulate(high, axis=0)[:-1])
            covered_m2 += width_m * float(np.maximum(high - low, 0.0).sum())
        return max(self.area_m2 - covered_m2, 0.0)


@dataclass(frozen=True)
class Target:
    """An object that was buried for the trial: its row, its name, its lane and its centre [m]."""

    row: Row
    name: str
    lane: str
    place_m: Place


@dataclass(frozen=True)
class Group:
    """Targets that are counted together, and the lanes whose false alarms go with them."""

    name: str  # such as "type PMN"; empty: all
    targets: List[str]
    lanes: List[str]


def lane_of(row: Row) -> Lane:
    """Return the lane of a row.

    Raises:
        UnreadableFileError: A cell is not allowed.
    """
    left, right, near, far = (row.number(one, -MOST_M, MOST_M) for one in LANE_COLUMNS[1:])
    for column, low, high in (("x_max_m", left, right), ("y_max_m", near, far)):
        if not low < high:
            row.refuse(column, Message("more than {low:g}", low=low))
    return Lane(row, (left, near), (right, far))


def read_lanes(content: bytes, file: str) -> Dict[str, Lane]:
    """Return the lanes of a table by their names.

    Raises:
        UnreadableFileError: It is no table of lanes.
    """
    rows = read_table(content, file, LANE_COLUMNS, at_least_one=True)
    return {row.text("lane"): lane_of(row) for row in rows}


def read_targets(content: bytes, file: str, lanes: Mapping[str, Lane]) -> List[Target]:
    """Return the targets of a table.

    Raises:
        UnreadableFileError: It is no table of targets in these lanes.
    """
    targets = []
    for row in read_table(content, file, TARGET_COLUMNS, at_least_one=True):
        lane = lanes.get(row.text("lane"))
        if lane is None:
            row.refuse("lane", Message("one of the lanes {lanes}", lanes=", ".join(lanes)))
        (left, near), (right, far) = lane.low_m, lane.high_m
        place_m = row.number("x_m", left, right), row.number("y_m", near, far)
        row.number("depth_m", 0.0, MOST_DEPTH_M)
        if row.cells.get("diameter_m"):
            row.number("diameter_m", 0.0, MOST_DEPTH_M)
        if row.cells.get("burial_date"):
            try:
                datetime.date.fromisoformat(row.cells["burial_date"])
            except ValueError:
                row.refuse("burial_date", Message("a date such as {example}", example="2026-11-27"))
        row.text("type")
        targets.append(Target(row, row.text("target"), row.text("lane"), place_m))
    return targets


def groups_of(
    columns: Sequence[str], targets: Sequence[Target], lanes: Mapping[str, Lane]
) -> List[Group]:
    """Return all targets, then those of each value of each column.

    Args:
        columns: Each is a column of the lanes or, if they lack it, of the targets.
        targets: The targets.
        lanes: The lanes by their names; a value of a lane limits them, one of a target does not.

    Raises:
        UnreadableFileError: A table lacks a column, or a cell is empty.
    """
    groups = [Group("", [one.name for one in targets], list(lanes))]
    for column in columns:
        is_of_lanes = any(column in one.row.cells for one in lanes.values())
        members: Dict[str, List[str]] = {}
        for target in targets:
            row = lanes[target.lane].row if is_of_lanes else target.row
            members.setdefault(row.text(column), []).append(target.name)
        for value, names in sorted(members.items()):
            near = [
                name
                for name, lane in lanes.items()
                if not is_of_lanes or lane.row.cells.get(column) == value
            ]
            groups.append(Group(f"{column} {value}", names, near))
    return groups
