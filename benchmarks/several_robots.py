"""What each further robot on one ROS master costs the computer that stores the surveys.

    scripts/bench.sh several_robots [--robots 1 2 4] [--speed 20] [--json FILE]

Launches so many simulated robots, each in a namespace of its own, lets all of them survey at once,
and reads the processor time of the nodes that a server runs for each robot.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, List

import psutil
from graph_kit import ROOT, arguments, environment_of, finish, print_table, processor_s
from robot_kit import free_port, resident_mib, running

# What server.launch starts.
SERVER = ("vna_acquisition", "vna_processing", "imaging", "main_control")
# 36 stops with two rotations.
AREA = ("--x-start-mm=100", "--x-stop-mm=150", "--x-points=6",
        "--y-start-mm=100", "--y-stop-mm=150", "--y-points=6")  # fmt: skip
TRACES = 72
START_LIMIT_S = 120.0
MILLI = 1e3


def server_nodes(launches: List[subprocess.Popen]) -> List[psutil.Process]:
    """Return the processes of the nodes that a server runs."""
    found = []
    for launch in launches:
        for child in psutil.Process(launch.pid).children():
            with contextlib.suppress(psutil.NoSuchProcess):  # ended meanwhile
                if any(f"__name:={name}" in child.cmdline() for name in SERVER):
                    found.append(child)
    return found


def survey_at_once(launches: List[subprocess.Popen]) -> float:
    """Let every robot survey; return how long the last one took [s].

    Raises:
        SystemExit: A survey did not finish.
    """
    begun_s = time.monotonic()
    clients = [
        subprocess.Popen(
            ["rosrun", "gpr20_user_interface", "run_survey", f"--wait={START_LIMIT_S:g}",
             "--bar=never", *AREA, f"__ns:=robot{number}"],
            stdout=subprocess.DEVNULL,
        )
        for number in range(1, len(launches) + 1)
    ]  # fmt: skip
    if any([client.wait() for client in clients]):
        raise SystemExit("a survey did not finish")
    return time.monotonic() - begun_s


def measure(robots: int, speed: float) -> Dict[str, float]:
    """Return the figures of one number of robots."""
    with tempfile.TemporaryDirectory(
        prefix="gpr20_robots_"
    ) as folder, contextlib.ExitStack() as on:
        port = str(free_port())
        on.enter_context(environment_of(ROOT, GPR20_CONFIG="", ROS_LOG_DIR=folder))
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        on.enter_context(running("roscore", "-p", port))
        launches = [
            on.enter_context(
                running(
                    *("roslaunch", "--wait", "gpr20", "survey.launch", "ui:=false"),
                    *(f"ns:=robot{number}", f"data:={folder}/{number}", f"time_scale:={speed:g}"),
                    stderr=subprocess.DEVNULL,
                )
            )
            for number in range(1, robots + 1)
        ]
        # The first survey of each also starts everything.
        survey_at_once(launches)
        nodes = server_nodes(launches)
        if len(nodes) != robots * len(SERVER):
            raise SystemExit(f"only {len(nodes)} nodes of servers are there")
        before_s = sum(map(processor_s, nodes))
        took_s = survey_at_once(launches)
        return {
            "robots": robots,
            "processor_ms_per_trace": MILLI
            * (sum(map(processor_s, nodes)) - before_s)
            / (robots * TRACES),
            "memory_mib_per_robot": sum(resident_mib(node.pid) for node in nodes) / robots,
            "survey_s": took_s,
            "bytes_per_trace": _bytes(Path(folder)) / (2 * robots * TRACES),
        }


def _bytes(folder: Path) -> int:
    surveys = [path.parent for path in folder.glob("*/*/survey.json")]
    return sum(one.stat().st_size for survey in surveys for one in survey.rglob("*.*"))


def main() -> None:
    parser = arguments(__doc__ or "")
    parser.add_argument("--robots", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--speed", type=float, default=20.0, help="times the real robot's (20)")
    chosen: argparse.Namespace = parser.parse_args()
    figures: List[Dict[str, Any]] = [measure(robots, chosen.speed) for robots in chosen.robots]
    columns = list(figures[0])
    print_table(
        columns, [[f"{one[name]:.1f}" if name != "robots" else str(one[name]) for name in columns]
                  for one in figures],
    )  # fmt: skip
    finish(chosen, {"benchmark": "several_robots", "figures": figures})


if __name__ == "__main__":
    main()
