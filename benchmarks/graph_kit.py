"""A survey of the launched simulated robot: its traces, and what its processes did meanwhile."""

from __future__ import annotations

import contextlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Dict, Iterator, List, Sequence, Tuple

import psutil
from robot_kit import START_LIMIT_S, LaunchedRobot, simulated_robot

TAP = Path(__file__).resolve().parent / "graph_tap"
PERCENT = 100.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Sample:
    """The times of one trace [us since 1970], and its place."""

    index: int
    started_us: int
    ended_us: int
    x_mm: float
    y_mm: float
    z_deg: float


@dataclass(frozen=True)
class Event:
    """Something that a tap has noted."""

    time_s: float
    process: int
    kind: str
    name: str
    phase: str


@contextlib.contextmanager
def tapped_robot(*options: str) -> Iterator[Tuple[LaunchedRobot, Path]]:
    """Launch the simulated robot; yield it and the file where calls between nodes are noted."""
    with tempfile.TemporaryDirectory(prefix="gpr20_tap_") as folder:
        file = Path(folder) / "tap"
        path = f"{TAP}:{os.environ['PYTHONPATH']}"
        # The configuration of a robot that is installed here is left alone.
        os.environ.update(GPR20_TAP=str(file), PYTHONPATH=path, GPR20_CONFIG="")
        with simulated_robot(*options) as robot:
            yield robot, file


def run_survey(robot: LaunchedRobot, *options: str) -> Path:
    """Run a survey to its end and return its folder.

    Raises:
        SystemExit: It did not finish.
    """
    client = robot.client(
        f"--wait={START_LIMIT_S:g}", *options, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )  # fmt: skip
    printed, _ = client.communicate()
    if client.returncode != 0:
        sys.stderr.write(printed.decode())
        raise SystemExit(f"the survey did not finish (status {client.returncode})")
    (described,) = robot.data.glob("*/survey.json")
    return described.parent


def samples(survey: Path) -> List[Sample]:
    """Return the samples of a survey in their order."""
    found = []
    for path in sorted((survey / "traces").glob("*.json")):
        values = json.loads(path.read_text())
        place = (values["x_coord_mm"], values["y_coord_mm"], values["z_coord_deg"])
        times = (_us(values["sweep_started"]), _us(values["sweep_ended"]))
        found.append(Sample(values["index"], *times, *place))
    return found


def _us(text: str) -> int:
    return round(datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp() * 1e6)


def events(file: Path) -> List[Event]:
    """Return what was noted since the launch, in the order of time."""
    found = []
    for line in file.read_text().splitlines():
        time_ns, process, kind, name, phase = line.split("\t")
        found.append(Event(int(time_ns) * 1e-9, int(process), kind, name, phase))
    return sorted(found, key=lambda event: event.time_s)


def intervals(noted: Sequence[Event], kind: str, name: str) -> List[Tuple[float, float]]:
    """Return begin and end of each call of a kind whose name ends so [s], in their order."""
    open_s: Dict[int, List[float]] = {}
    found = []
    for event in noted:
        if event.kind != kind or not event.name.endswith(name):
            continue
        begun = open_s.setdefault(event.process, [])
        if event.phase == "B":
            begun.append(event.time_s)
        elif begun:
            found.append((begun.pop(0), event.time_s))
    return sorted(found)


def processor_s(process: psutil.Process) -> float:
    """Return the time that a process and its children have used so far [s]."""
    total = 0
    for one in (process, *process.children(recursive=True)):
        # The second field is the program's name in parentheses, and may hold spaces.
        fields = Path(f"/proc/{one.pid}/stat").read_text().rpartition(")")[2].split()
        total += int(fields[11]) + int(fields[12])
    return total / TICKS_PER_S


def median(values: Sequence[float]) -> float:
    """Return the median; NaN of nothing."""
    return statistics.median(values) if values else float("nan")


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table as Markdown, and the load; all columns but the first are numbers."""
    print("| " + " | ".join(columns) + " |")
    print("| --- |" + " ---: |" * (len(columns) - 1))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print("load average: {:.2f} {:.2f} {:.2f}".format(*os.getloadavg()))
