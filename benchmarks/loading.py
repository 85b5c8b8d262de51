"""Load one survey of 25,000 traces of 501 points from each kind of file: time and memory.

Each load runs in a process of its own, three times; the smallest time counts (files in the
system's cache). The survey is made first, of noise, by the storage's own writers. At last the real
window opens it, through a vna_processing of its own.

    scripts/bench.sh loading [--x-points 125 --y-points 100] [--folder DIR] [--window]
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Dict

import recorded_survey_kit
import rospy
from PyQt5.QtWidgets import QApplication
from robot_kit import free_port, running
from window import Heartbeat
from window_kit import new_window, run_events, run_until, virtual_screen

from gpr20_analysis import load_survey, write_dataset
from gpr20_common.catalogue import Language
from gpr20_user_interface.look.translation import Languages

NODE = (
    Path(__file__).resolve().parents[1] / "catkin_ws/src/gpr20_vna_processing/nodes/vna_processing"
)
AS_LAUNCHED = {"OPENBLAS_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1"}
FOLDER = "20260921T141320_0f8fad5b"
# So many are shown first.
FIRST = 1000
FIRST_LIMIT_S, WHOLE_LIMIT_S, GIVEN_UP_S = 5.0, 60.0, 1200.0
MOST_GROWN_MIB = 100.0
SETTLING_S = 3.0
REPEATS = 3
MIB = 1 << 20
LIMITS_S = {"MCAP": 2.0, "bag": 3.0, "JSON": 8.0, "NetCDF": 1.0}
LOAD = """
import json, re, sys, time
from pathlib import Path
from gpr20_analysis import load_survey
path = Path(sys.argv[1])
# Of this program alone: the figure of getrusage begins with that of the one that started it.
peak = lambda: 1024 * int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
before, wall_s, cpu_s = peak(), time.perf_counter(), time.process_time()
survey = load_survey(path)
print(json.dumps({
    "wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s,
    "grown": peak() - before, "data": survey.s21.nbytes,
}))
"""


def measure(path: Path) -> Dict[str, float]:
    """Return the fastest of several loads."""
    runs = [
        json.loads(subprocess.check_output([sys.executable, "-c", LOAD, str(path)]))
        for _ in range(REPEATS)
    ]
    return min(runs, key=lambda one: one["wall_s"])


def row(name: str, found: Dict[str, float]) -> str:
    ratio = found["grown"] / found["data"]
    return (
        f"| {name} | {found['wall_s']:.2f} | {found['cpu_s']:.2f} | {LIMITS_S[name]:g} | "
        f"{found['grown'] / MIB:.0f} | {ratio:.2f} |"
    )


def load_from_files(folder: Path) -> bool:
    """Load the survey from each kind of file and print the table; return if a limit is missed."""
    copy = folder.parent.parent / "survey.nc"
    write_dataset(load_survey(folder / "survey.mcap"), copy)
    paths = {
        "MCAP": folder / "survey.mcap",
        "bag": folder / "survey.bag",
        "JSON": folder,
        "NetCDF": copy,
    }
    print("| from | s | processor s | limit s | memory MiB | of the data |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    missed = False
    for name, path in paths.items():
        found = measure(path)
        print(row(name, found), flush=True)
        missed |= found["wall_s"] > LIMITS_S[name] or found["grown"] > 2 * found["data"]
    return missed


def open_in_window(data: Path, traces: int) -> bool:
    """Open the survey in the real window and print how long that takes; return if it is too long.

    Args:
        data: Folder of the surveys.
        traces: How many traces it has.
    """
    port = free_port()
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    own = {**os.environ, **AS_LAUNCHED, "GPR20_DATA": str(data), "GPR20_STATE": f"{data}.state"}
    with running("roscore", "-p", str(port)), virtual_screen(), running(
        sys.executable, str(NODE), env=own
    ) as node:
        application = QApplication([])
        rospy.init_node("loading_benchmark", disable_signals=True)
        rospy.wait_for_service("read_traces", GIVEN_UP_S)
        interface = new_window(Languages(application, Language.ENGLISH), data)
        interface.begin()
        shown = interface.window.traces
        run_events(SETTLING_S)
        heartbeat = Heartbeat()
        heartbeat.start()
        before_mib, begin_s = peak_mib(node.pid), time.monotonic()
        shown.open_survey(FOLDER)
        at_s = []
        for count in (min(FIRST, traces), traces):
            run_until(lambda: shown.shown.radar.count >= count, f"{count} traces", GIVEN_UP_S)  # noqa: B023
            at_s.append(time.monotonic() - begin_s)
        grown_mib = peak_mib(node.pid) - before_mib
        print("| first s | whole s | window busy, longest ms | node grown MiB |")
        print("| ---: | ---: | ---: | ---: |")
        longest_ms = 1e3 * max(heartbeat.gaps_s)
        print(f"| {at_s[0]:.1f} | {at_s[1]:.1f} | {longest_ms:.0f} | {grown_mib:.0f} |")
        interface.end()
        rospy.signal_shutdown("measured")
    return at_s[0] > FIRST_LIMIT_S or at_s[1] > WHOLE_LIMIT_S or grown_mib > MOST_GROWN_MIB


def peak_mib(pid: int) -> float:
    """Return the most memory that a process has used so far [MiB]."""
    status = Path(f"/proc/{pid}/status").read_text()
    found = re.search(r"VmHWM:\s*(\d+)", status)
    assert found is not None
    return int(found[1]) / 1024


def main() -> int:
    """Measure and print; return 1 if a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--x-points", type=int, default=125)
    parser.add_argument("--y-points", type=int, default=100)
    parser.add_argument("--folder", type=Path, help="where the survey is made; default temporary")
    parser.add_argument("--window", action="store_true", help="only the window")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=chosen.folder) as temporary:
        folder = Path(temporary) / "data" / FOLDER
        traces = recorded_survey_kit.make(folder, chosen.x_points, chosen.y_points)
        print(f"{traces} traces of 501 points, load average {_load()}")
        missed = False if chosen.window else load_from_files(folder)
        missed |= open_in_window(folder.parent, traces)
    return int(missed)


def _load() -> Any:
    return Path("/proc/loadavg").read_text().split()[0]


if __name__ == "__main__":
    sys.exit(main())
