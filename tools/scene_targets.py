"""Compare the targets of a simulated ground with the candidates in the image of its survey.

The standard input is what `gpr20 candidates --json` prints; see survey.sh.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any, Dict, Iterator, Tuple

import yaml

# A candidate farther from a target than this is another object.
REACH_MM = 30.0
LINE = "  {:18} {:24} {}"


def table(scene: Dict[str, Any], listed: Dict[str, Any]) -> Iterator[str]:
    """Yield a line for each target: where it is, and where the image shows it."""
    shown = [
        (1000.0 * one["x_m"], 1000.0 * one["y_m"], 1000.0 * one["depth_m"])
        for one in listed["candidates"]
        if not {"clutter", "sidelobe"}.intersection(one["flags"])
    ]
    yield LINE.format("", "buried at [mm]", "found in the image at [mm]")
    for one in scene["targets"]:
        x_mm, y_mm = one["x_mm"], one["y_mm"]
        near = [(math.hypot(place[0] - x_mm, place[1] - y_mm), place) for place in shown]
        off_mm, place = min(near, default=(math.inf, (0.0, 0.0, 0.0)))
        found = _text(place) if off_mm <= REACH_MM else "not found"
        yield LINE.format(one["name"], _text((x_mm, y_mm, 1000.0 * one["depth_m"])), found)


def _text(place: Tuple[float, ...]) -> str:
    return "x {:.0f}, y {:.0f}, depth {:.0f}".format(*place)


if __name__ == "__main__":
    # With --permittivity only that of the soil.
    described = yaml.safe_load(Path(sys.argv[1]).read_text(encoding="utf-8"))
    if "--permittivity" in sys.argv:
        print(described["soil"]["relative_permittivity"])
    else:
        print("\n".join(table(described, json.load(sys.stdin))))
