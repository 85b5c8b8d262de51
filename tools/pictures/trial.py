"""The report of a trial that is made up, with targets and two methods drawn at random."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import random
import tempfile
from pathlib import Path
from typing import Dict, List, Tuple

from gpr20_analysis.commands.main import main
from pictures.report import photograph

SEED, LANES, COLUMNS, ROWS = 29, 4, 8, 2
HALO_M, OFF_M = 0.15, 0.04
TYPES = ("plastic", "metal")
DEPTHS_M = ("0.05", "0.10")
# Chance that a method finds a target of each type, and false alarms per lane.
METHODS: Dict[str, Tuple[Dict[str, float], int]] = {
    "radar": ({"plastic": 0.85, "metal": 0.97}, 6),
    "detector": ({"plastic": 0.6, "metal": 0.98}, 11),
}


def make(folder: Path) -> None:
    """Score the trial with the command, and take a picture of its report."""
    with tempfile.TemporaryDirectory() as place, contextlib.redirect_stdout(io.StringIO()):
        photograph(_score(Path(place)), folder / "trial.png")


def _score(place: Path) -> Path:
    chance = random.Random(SEED)
    targets, plan, report = (place / name for name in ("targets.csv", "plan.yaml", "report.html"))
    sides = {"x_min_m": 0.0, "x_max_m": 8.0, "y_min_m": 0.0, "y_max_m": 2.0}
    lanes = {
        f"L{at}": {**sides, "notes": {"soil": "sand" if at % 2 else "loam"}} for at in range(LANES)
    }
    buried = [
        (f"L{lane}", 0.5 + column, 0.5 + row, chance.choice(TYPES), chance.choice(DEPTHS_M))
        for lane in range(LANES)
        for column in range(COLUMNS)
        for row in range(ROWS)
    ]
    rows = [
        f"T{at:02d},{lane},{x_m:.2f},{y_m:.2f},{depth},{kind}\n"
        for at, (lane, x_m, y_m, kind, depth) in enumerate(buried, 1)
    ]
    targets.write_text("target,lane,x_m,y_m,depth_m,type\n" + "".join(rows))
    sealed = hashlib.sha256(targets.read_bytes()).hexdigest()
    agreed = {"halo_m": HALO_M, "truth_sha256": sealed, "strata": ["type"], "lanes": lanes}
    plan.write_text(json.dumps(agreed))  # JSON is YAML
    lists: List[object] = []
    for method, (chances, false_alarms) in METHODS.items():
        for lane in (f"L{at}" for at in range(LANES)):
            places = [
                (one[1] + chance.gauss(0.0, OFF_M), one[2] + chance.gauss(0.0, OFF_M), 18.0)
                for one in buried
                if one[0] == lane and chance.random() < chances[one[3]]
            ]
            alarms = chance.randrange(false_alarms)
            places += [(chance.uniform(0, 8), chance.uniform(0, 2), 12.0) for _ in range(alarms)]
            # The most certain candidate first.
            places.sort(key=lambda one: one[2] + chance.gauss(0.0, 4.0), reverse=True)
            marks = [
                f"C{at:02d},{x_m:.3f},{y_m:.3f}\n" for at, (x_m, y_m, _) in enumerate(places, 1)
            ]
            listed = place / f"{method}_{lane}.csv"
            listed.write_text("id,x_m,y_m\n" + "".join(marks))
            lists += ["--list", method, lane, listed]
    _run(plan, "--truth", targets, *lists, "-o", report)
    return report


def _run(*arguments: object) -> None:
    if main(["trial", *map(str, arguments)]) != 0:
        raise SystemExit("the trial was not made")
