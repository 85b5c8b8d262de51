"""One long survey through the whole graph: memory of every node, stalls, and all warnings.

Launches the simulated robot at a high time scale on loopback, runs one survey with the
terminal client, and prints a table. Ends with status 1 if the survey did not finish, a node's
memory grew by more than 5 % from the first row to the last, or a trace came later than
the limit of a wait. Everything lies in a temporary folder that is removed afterwards.

    scripts/bench.sh soak [--x-points 100 --y-points 50] [--time-scale 200]
"""

from __future__ import annotations

import argparse
import collections
import subprocess
import sys
import time
from typing import Counter, Dict, List

import rospy
from robot_kit import MASTER, NODES, START_LIMIT_S, LaunchedRobot, resident_mib, simulated_robot
from rosgraph_msgs.msg import Log

from gpr20_msgs.msg import Trace

POLARIZATIONS = 2
ROWS = 10
PROCESSES = (*NODES, MASTER)
ALLOWED_GROWTH = 0.05
# The storage keeps the index of its recordings, at most so much per trace [MiB].
INDEX_MIB = {"vna_processing": 3.5e-3}
# No wait of the survey is longer; a trace that takes as long is a stall.
LONGEST_GAP_S = 5.0


class Ear:
    """Hears the traces and the warnings."""

    def __init__(self) -> None:
        self.count = 0
        self.longest_gap_s = 0.0
        self.warnings: Counter = collections.Counter()
        self._last_s = 0.0
        self._subscribers = [
            rospy.Subscriber("trace", Trace, self._hear_trace, queue_size=1000),
            rospy.Subscriber("/rosout_agg", Log, self._hear_log, queue_size=1000),
        ]

    def _hear_trace(self, _trace: Trace) -> None:
        now_s = time.monotonic()
        if self.count:
            self.longest_gap_s = max(self.longest_gap_s, now_s - self._last_s)
        self._last_s = now_s
        self.count += 1

    def _hear_log(self, entry: Log) -> None:
        if entry.level >= Log.WARN:
            self.warnings[f"{entry.name}: {entry.msg[:120]}"] += 1


def memory_mib(robot: LaunchedRobot) -> Dict[str, float]:
    """Return the resident memory of each node [MiB], with the processes it started."""
    found: Dict[str, float] = dict.fromkeys(PROCESSES, 0.0)
    for name, process in robot.processes().items():
        found[name] = resident_mib(process.pid, with_children=True)
    return found


def table(rows: List[Dict[str, float]]) -> str:
    names = ["count", "seconds", *PROCESSES]
    lines = [
        "| traces | time [s] | " + " | ".join(PROCESSES) + " |",
        "| " + " | ".join(["---:"] * len(names)) + " |",
    ]
    for row in rows:
        cells = [f"{row['count']:,.0f}", f"{row['seconds']:.0f}"]
        lines.append(
            "| " + " | ".join([*cells, *(f"{row[name]:.1f}" for name in PROCESSES)]) + " |"
        )
    return "\n".join(lines)


def watch(robot: LaunchedRobot, client: subprocess.Popen, ear: Ear, total: int) -> list:
    """Note the memory ten times during the survey; return the rows."""
    rows: List[Dict[str, float]] = []
    begin_s = time.monotonic()
    for mark in range(total // ROWS, total + 1, total // ROWS):
        while ear.count < mark and client.poll() is None:
            time.sleep(0.05)
        if client.poll() is None or ear.count >= mark:
            seconds = time.monotonic() - begin_s
            rows.append({"count": ear.count, "seconds": seconds, **memory_mib(robot)})
            print(rows[-1], file=sys.stderr, flush=True)
    client.wait()
    return rows


def verdict(rows: List[Dict[str, float]], ear: Ear, status: int) -> int:
    """Print what was found; return the exit status."""
    print("Memory of the nodes [MiB], with the processes they started:\n\n" + table(rows))
    first, last = rows[0], rows[-1]
    traces = last["count"] - first["count"]
    growth = {
        name: (last[name] - traces * INDEX_MIB.get(name, 0.0)) / first[name] - 1.0
        for name in PROCESSES
    }
    worst = max(growth, key=lambda name: growth[name])
    print(
        f"\nLargest growth from {first['count']:,} traces on, beside the storage's index: {worst} "
        f"{growth[worst]:+.1%}."
    )
    print(f"{ear.count:,} traces, {ear.count / rows[-1]['seconds']:.1f} per second.")
    print(f"Longest time between two traces: {ear.longest_gap_s:.2f} s.")
    print(f"Warnings and errors: {sum(ear.warnings.values())}")
    for text, times in ear.warnings.most_common(20):
        print(f"  {times} x {text}")
    print(f"Exit status of the terminal client: {status}.")
    flat = growth[worst] <= ALLOWED_GROWTH
    return 0 if flat and status == 0 and ear.longest_gap_s < LONGEST_GAP_S else 1


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--x-points", type=int, default=100)
    options.add_argument("--y-points", type=int, default=50)
    options.add_argument("--time-scale", type=float, default=200.0)
    chosen = options.parse_args()
    total = chosen.x_points * chosen.y_points * POLARIZATIONS
    with simulated_robot(f"time_scale:={chosen.time_scale:g}") as robot:
        rospy.init_node("soak", disable_signals=True)
        ear = Ear()
        client = robot.client(
            *(f"--wait={START_LIMIT_S:.0f}", "--x-start=10", f"--x-stop={10 + chosen.x_points}"),
            *(f"--x-points={chosen.x_points}", "--y-start=10", f"--y-stop={10 + chosen.y_points}"),
            f"--y-points={chosen.y_points}",
            stdout=subprocess.DEVNULL,
        )
        rows = watch(robot, client, ear, total)
        return verdict(rows, ear, client.returncode)


if __name__ == "__main__":
    sys.exit(main())
