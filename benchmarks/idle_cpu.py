"""What the nodes of the launched robot cost while nothing happens.

    scripts/bench.sh idle_cpu [--workspace DIR --workspace DIR] [--seconds 30] [--json FILE]

Launches the simulated robot at its real speed and reads the processor time of each node, and of the
processes it has started, from /proc before and after a time of rest: after the launch, after a
small survey, and with the window on a screen of its own.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
import signal
import time
from pathlib import Path
from subprocess import DEVNULL
from typing import Dict, Iterator, List

import psutil
from graph_kit import (
    PERCENT,
    arguments,
    finish,
    launched,
    median,
    print_table,
    processor_s,
    run_survey,
)
from graph_kit import workspaces as chosen_workspaces
from robot_kit import MASTER, NODES, LaunchedRobot, running

WINDOW = "user_interface"
PROCESSES = (*NODES, WINDOW, MASTER)
STATES = ("launched", "after a survey", "with the window")
# Start-up has ended after this.
CALM_S = 8.0
SCREEN = "800x480x24"
Load = Dict[str, float]


@contextlib.contextmanager
def screen() -> Iterator[None]:
    """Let the window draw on an X server of its own."""
    program = shutil.which("Xvfb")
    if program is None:
        raise SystemExit("Xvfb is missing; run scripts/setup.sh --dev")
    reading, writing = os.pipe()
    command = [program, "-displayfd", str(writing), "-screen", "0", SCREEN, "-nolisten", "tcp"]
    former = os.environ.get("DISPLAY")
    with running(*command, end_by=signal.SIGTERM, pass_fds=[writing], stderr=DEVNULL):
        os.close(writing)
        with os.fdopen(reading) as answer:
            os.environ["DISPLAY"] = f":{answer.readline().strip()}"
        yield
    os.environ.pop("DISPLAY")
    if former is not None:
        os.environ["DISPLAY"] = former


def processes(robot: LaunchedRobot) -> Dict[str, psutil.Process]:
    """Return the nodes by their names; the window and the launch, too."""
    found = dict(robot.processes())
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):  # ended meanwhile, or another user's
            parents = [one.pid for one in process.parents()]
            if os.getpid() in parents and f"/{WINDOW}-" in " ".join(process.cmdline()):
                found[WINDOW] = process
    return found


def at_rest(robot: LaunchedRobot, seconds: float) -> Load:
    """Return the load of each process while nothing happens [% of a core]."""
    time.sleep(CALM_S)
    watched = processes(robot)
    begun_s = time.monotonic()
    before = {name: processor_s(process) for name, process in watched.items()}
    time.sleep(seconds)
    elapsed_s = time.monotonic() - begun_s
    return {
        name: PERCENT * (processor_s(process) - before[name]) / elapsed_s
        for name, process in watched.items()
    }


def measure(root: Path, state: str, seconds: float) -> Load:
    """Return the load of one state of the robot [% of a core]."""
    if state == "with the window":
        with screen(), launched(root, launch="gpr20 survey.launch ui:=true") as robot:
            return at_rest(robot, seconds)
    with launched(root, *(() if state == "launched" else ("time_scale:=50",))) as robot:
        if state == "after a survey":
            run_survey(robot, "--x-points=3", "--y-points=3")
        return at_rest(robot, seconds)


def report(merged: Dict[str, Dict[str, List[Load]]]) -> Dict[str, Dict[str, Load]]:
    """Print a table; return its figures."""
    medians: Dict[str, Dict[str, Load]] = {
        label: {
            state: {
                name: median([load[name] for load in loads if name in load]) for name in PROCESSES
            }
            for state, loads in states.items()
        }
        for label, states in merged.items()
    }
    columns = [(label, state) for label, states in medians.items() for state in states]
    print("\npercent of one core\n")
    print_table(
        ["process", *(f"{label}, {state}" for label, state in columns)],
        [
            [name, *(f"{medians[label][state][name]:.2f}" for label, state in columns)]
            for name in PROCESSES
        ],
    )
    return medians


def main() -> None:
    parser = arguments(__doc__ or "")
    parser.add_argument("--seconds", type=float, default=30.0, help="length of the rest (30)")
    parser.add_argument("--states", nargs="+", choices=STATES, default=list(STATES))
    chosen: argparse.Namespace = parser.parse_args()
    merged: Dict[str, Dict[str, List[Load]]] = {}
    for number in range(chosen.rounds):
        for state in chosen.states:
            for root in chosen_workspaces(chosen):
                load = measure(root, state, chosen.seconds)
                states = merged.setdefault(str(root), {})
                states.setdefault(state, []).append(load)
                print(f"round {number + 1}: {root}, {state}: {sum(load.values()):.1f} % in all")
    finish(chosen, {"benchmark": "idle_cpu", "unit": "% of a core", "figures": report(merged)})


if __name__ == "__main__":
    main()
