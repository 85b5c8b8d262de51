"""Surveys of the launched simulated robot, of this checkout or of another one, and their times.

Benchmarks that compare two versions launch both in turn: `--workspace DIR` names the root of a
built checkout and may be repeated.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Tuple

import psutil
from robot_kit import START_LIMIT_S, LaunchedRobot

ROOT = Path(__file__).resolve().parents[1]
TAP = Path(__file__).resolve().parent / "graph_tap"
PERCENT = 100.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# What the environment of another checkout must not inherit is left out.
INHERITED = ("HOME", "USER", "LANG", "LC_ALL", "TERM", "DISPLAY", "TMPDIR")
SYSTEM_PATH = "/usr/local/bin:/usr/bin:/bin"


def arguments(description: str) -> argparse.ArgumentParser:
    """Return a parser with the options that every benchmark of the graph has."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    parser.add_argument(
        "--workspace",
        type=Path,
        action="append",
        metavar="DIR",
        help="root of a built checkout that is measured; repeat it to compare (default: this one)",
    )
    parser.add_argument("--rounds", type=int, default=1, help="times that each is measured (1)")
    return parser


def workspaces(chosen: argparse.Namespace) -> List[Path]:
    """Return the roots that are measured.

    Raises:
        SystemExit: One is not built.
    """
    roots = [root.resolve() for root in chosen.workspace or [ROOT]]
    for root in roots:
        needed = (root / "catkin_ws/devel/setup.bash", root / ".venv/bin/python")
        for path in needed:
            if not path.exists():
                raise SystemExit(f"{path} is missing; run {root}/scripts/setup.sh first")
    return roots


@contextlib.contextmanager
def environment_of(root: Path, **added: str) -> Iterator[None]:
    """Let the processes that are started meanwhile be those of a checkout."""
    inherited = {name: os.environ[name] for name in INHERITED if name in os.environ}
    script = f"source {root}/catkin_ws/devel/setup.bash && env -0"
    printed = subprocess.run(
        ["bash", "-c", script],
        env={**inherited, "PATH": f"{root}/.venv/bin:{SYSTEM_PATH}"},
        stdout=subprocess.PIPE,
        check=True,
    ).stdout.decode()
    found = dict(line.split("=", 1) for line in printed.split("\0") if line)
    found["PATH"] = f"{root}/.venv/bin:{found['PATH']}"
    former = dict(os.environ)
    os.environ.clear()
    os.environ.update({**found, **added})
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(former)


@contextlib.contextmanager
def launched(
    root: Path,
    *options: str,
    tap: bool = False,
    message_ms: float = 0.0,
) -> Iterator[LaunchedRobot]:
    """Launch the simulated robot of a checkout; its folder is removed in the end.

    Args:
        root: The checkout.
        options: Arguments of the launch file.
        tap: Whether calls between nodes are noted, in the file `tap` of the robot's folder.
        message_ms: How long the simulated instrument takes for each message [ms]; needs `tap`.
    """  # fmt: skip
    # A benchmark that is terminated ends its robot, too.
    signal.signal(signal.SIGTERM, lambda number, _frame: sys.exit(128 + number))
    with tempfile.TemporaryDirectory(prefix="gpr20_bench_") as name:
        folder = Path(name)
        # Neither the configuration of a robot that is installed here nor its logs are touched.
        added = {"ROS_LOG_DIR": str(folder / "log"), "GPR20_CONFIG": ""}
        with environment_of(root, **added):
            if tap:
                os.environ["GPR20_TAP"] = str(folder / "tap")
                os.environ["GPR20_TAP_MESSAGE_MS"] = f"{message_ms:g}"
                os.environ["PYTHONPATH"] = f"{TAP}:{os.environ['PYTHONPATH']}"
            robot = LaunchedRobot(folder, *options)
            try:
                robot.start()
                yield robot
            finally:
                robot.stop()


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


def run_survey(robot: LaunchedRobot, *options: str) -> Path:
    """Run a survey to its end and return its folder.

    Raises:
        SystemExit: It did not finish.
    """
    before = set(_surveys(robot))
    client = robot.client(
        f"--wait={START_LIMIT_S:g}", "--bar=never", *options, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )  # fmt: skip
    printed, _ = client.communicate()
    if client.returncode != 0:
        sys.stderr.write(printed.decode())
        raise SystemExit(f"the survey did not finish (status {client.returncode})")
    (folder,) = set(_surveys(robot)) - before
    return folder


def _surveys(robot: LaunchedRobot) -> List[Path]:
    return [path.parent for path in robot.data.glob("*/survey.json")]


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


def events(robot: LaunchedRobot) -> List[Event]:
    """Return what was noted since the launch, in the order of time."""
    found = []
    for line in (robot.data.parent / "tap").read_text().splitlines():
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
    """Print a table as Markdown; all columns but the first are numbers."""
    print("| " + " | ".join(columns) + " |")
    print("| --- |" + " ---: |" * (len(columns) - 1))
    for row in rows:
        print("| " + " | ".join(row) + " |")


def finish(chosen: argparse.Namespace, figures: Dict[str, Any]) -> None:
    """Print the load of the machine, and write the figures as JSON if that was asked for."""
    load = os.getloadavg()
    print(f"load average at the end: {load[0]:.2f} {load[1]:.2f} {load[2]:.2f}")
    if chosen.json is not None:
        values = {**figures, "load_average": load, "finished": datetime.now().isoformat()}
        chosen.json.write_text(json.dumps(values, indent=2) + "\n")
