"""Load one survey of 25,000 traces of 501 points from each kind of file: time and memory.

Each load runs in a process of its own, three times; the smallest time counts (files in the
system's cache). The survey is made first, of noise, by the storage's own writers.

    scripts/bench.sh loading [--x-points 125 --y-points 100] [--folder DIR]
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Dict

import recorded_survey_kit

from gpr20_analysis.read.load import load_survey
from gpr20_foreign_formats.merged_hdf5 import write_merged

REPEATS = 3
MIB = 1 << 20
LIMITS_S = {"MCAP": 2.0, "bag": 3.0, "JSON": 8.0, "HDF5": 1.0}
LOAD = """
import json, re, sys, time
from pathlib import Path
from gpr20_foreign_formats.merged_hdf5 import read_merged
from gpr20_analysis.read.load import load_survey
path = Path(sys.argv[1])
load = read_merged if path.suffix == ".h5" else load_survey
# Of this program alone: the figure of getrusage begins with that of the one that started it.
peak = lambda: 1024 * int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
before, wall_s, cpu_s = peak(), time.perf_counter(), time.process_time()
survey = load(path)
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


def main() -> int:
    """Measure and print; return 1 if a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--x-points", type=int, default=125)
    parser.add_argument("--y-points", type=int, default=100)
    parser.add_argument("--folder", type=Path, help="where the survey is made; default temporary")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=chosen.folder) as temporary:
        folder = Path(temporary) / "survey"
        traces = recorded_survey_kit.make(folder, chosen.x_points, chosen.y_points)
        merged = Path(temporary) / "merged.h5"
        write_merged(load_survey(folder / "survey.mcap"), merged, "benchmark")
        paths = {
            "MCAP": folder / "survey.mcap",
            "bag": folder / "survey.bag",
            "JSON": folder,
            "HDF5": merged,
        }
        print(f"{traces} traces of 501 points, load average {_load()}")
        print("| from | s | processor s | limit s | memory MiB | of the data |")
        print("| --- | ---: | ---: | ---: | ---: | ---: |")
        missed = False
        for name, path in paths.items():
            found = measure(path)
            print(row(name, found), flush=True)
            missed |= found["wall_s"] > LIMITS_S[name] or found["grown"] > 2 * found["data"]
    return int(missed)


def _load() -> Any:
    return Path("/proc/loadavg").read_text().split()[0]


if __name__ == "__main__":
    sys.exit(main())
