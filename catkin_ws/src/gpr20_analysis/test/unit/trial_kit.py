"""Small trials for tests: tables, lists of candidates, and the commands that use them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Iterable, List, Sequence, Tuple

from gpr20_analysis.commands.main import main

LANES = "lane,x_min_m,x_max_m,y_min_m,y_max_m,soil\nL1,0,4,0,1,sand\nL2,0,4,0,1,loam\n"
TARGET_HEADING = "target,lane,x_m,y_m,depth_m,type,diameter_m,orientation,burial_date"
TARGETS = "\n".join(
    [
        TARGET_HEADING,
        "T1,L1,0.5,0.5,0.05,PMN,0.11,flat,2026-10-01",
        "T2,L1,2.5,0.5,0.10,PMN,0.11,,2026-10-01",
        "T3,L2,0.5,0.5,0.05,TS-50,0.09,flat,",
        "T4,L2,3.98,0.98,0.10,TS-50,,,",
        "",
    ]
)
HALO_M = 0.1


class Trial:
    """A trial in a folder; `plan` makes its plan, `seal` a sealed list, `score` its score."""

    def __init__(self, folder: Path, lanes: str = LANES, targets: str = TARGETS) -> None:
        self.folder = folder
        self.truth, self.lanes = folder / "targets.csv", folder / "lanes.csv"
        self.truth.write_text(targets, encoding="utf-8")
        self.lanes.write_text(lanes, encoding="utf-8")
        self.file = folder / "plan.json"
        self.sealed: List[Path] = []

    @property
    def salt(self) -> Path:
        return self.folder / "targets.csv.salt"

    def plan(self, *options: str, halo_m: float = HALO_M) -> int:
        given = ("--halo", str(halo_m), "--strata", "type,soil", "-o", str(self.file), *options)
        return main(["trial", "plan", str(self.lanes), str(self.truth), *given])

    def seal(self, lane: str, marks: Iterable[Sequence[Any]], method: str = "radar") -> int:
        name = f"{method}_{lane}_{len(self.sealed)}"
        rows = [",".join(map(str, one)) for one in marks]
        listed = self.folder / f"{name}.csv"
        listed.write_text("\n".join(["id,x_m,y_m", *rows, ""]))
        sealed = self.folder / f"{name}.json"
        self.sealed.append(sealed)
        return self.seal_file(listed, sealed, lane, method)

    def seal_file(self, listed: Path, sealed: Path, lane: str, method: str = "radar") -> int:
        own = ("--lane", lane, "--method", method, "--operator", "Eva", "-o", str(sealed))
        return main(["trial", "seal", str(self.file), str(listed), *own])

    def score(self, *options: str) -> int:
        files = [str(one) for one in (self.file, *self.sealed)]
        return main(["trial", "score", *files, "--truth", str(self.truth), *options])


def marks_at(places: Iterable[Tuple[float, float]]) -> List[Tuple[Any, ...]]:
    """Return candidates at places, the first one the most certain."""
    return [(f"C{at:02d}", x, y) for at, (x, y) in enumerate(places, 1)]
