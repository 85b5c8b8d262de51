"""Compare the targets of a simulated ground with the candidates in the image of its survey.

The standard input is what `gpr20 candidates --json` prints; see survey.sh.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Sequence

import yaml

# A candidate farther from a target than this is another object [mm].
REACH_MM = 30.0
LINE = "  {name:18} {truth:24} {found}"


@dataclass(frozen=True)
class Place:
    """A point below the ground, in the coordinates of the survey [mm]."""

    x_mm: float
    y_mm: float
    depth_mm: float

    def distance_mm(self, other: Place) -> float:
        """Return the horizontal distance to another one [mm]."""
        return math.hypot(self.x_mm - other.x_mm, self.y_mm - other.y_mm)

    def __str__(self) -> str:
        return f"x {self.x_mm:.0f}, y {self.y_mm:.0f}, depth {self.depth_mm:.0f}"


def targets_of(scene: Dict[str, Any]) -> Dict[str, Place]:
    """Return where the targets of a scene are, by name."""
    return {
        one["name"]: Place(one["x_mm"], one["y_mm"], 1000.0 * one["depth_m"])
        for one in scene["targets"]
    }


def candidates_of(listed: Dict[str, Any]) -> List[Place]:
    """Return where the places to check of an image are."""
    doubtful = {"clutter", "sidelobe"}
    return [
        Place(1000.0 * one["x_m"], 1000.0 * one["y_m"], 1000.0 * one["depth_m"])
        for one in listed["candidates"]
        if not doubtful.intersection(one["flags"])
    ]


def table(targets: Dict[str, Place], candidates: Sequence[Place]) -> List[str]:
    """Return a line for each target: where it is, and where the image shows it."""
    lines = [LINE.format(name="", truth="buried at [mm]", found="found in the image at [mm]")]
    for name, target in targets.items():
        near = [one for one in candidates if target.distance_mm(one) <= REACH_MM]
        found = str(min(near, key=target.distance_mm)) if near else "not found"
        lines.append(LINE.format(name=name, truth=str(target), found=found))
    return lines


def main() -> None:
    """Print the table, or only the soil of the scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--permittivity", action="store_true", help="print that of the soil only")
    chosen = parser.parse_args()
    scene = yaml.safe_load(chosen.scene.read_text(encoding="utf-8"))
    if chosen.permittivity:
        print(scene["soil"]["relative_permittivity"])
    else:
        print("\n".join(table(targets_of(scene), candidates_of(json.load(sys.stdin)))))


if __name__ == "__main__":
    main()
