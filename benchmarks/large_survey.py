"""What memory `gpr20 process` needs for a survey that does not fit into it.

Usage: scripts/bench.sh large_survey [--gib 2] [--limit-mib 1024] [--folder /tmp] [--ending .nc]

A survey of noise is written in parts, then each chain of steps runs in a process of its own whose
memory is limited (RLIMIT_DATA: the heap and every other private memory, so an attempt to have more
is refused by the kernel, and the command fails). Printed are the time and the largest memory that
was resident, which counts the libraries too.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import List

import dask.array
import numpy as np

from gpr20_analysis.formats.common import Imported, as_dataset
from gpr20_analysis.formats.dataset_files import write_dataset

POINTS, ROTATIONS_DEG, STEP_M, HEIGHT_M = 1001, [0.0, 90.0], 0.01, 0.2
START_HZ, STOP_HZ = 600e6, 6e9
ROWS_AT_ONCE = 4
MIB = 1 << 20
KIB_PER_MIB = 1024.0
CHAINS = {
    "mean, time zero": ["background:method=mean", "time_zero"],
    "SVD": ["background:method=svd,rank=2"],
    "median": ["background:method=median"],
    "moving, fill, combine": ["background:method=moving,width=11", "fill", "combine"],
    "window, time, AGC": ["window", "time:padding=1", "gain:method=agc"],
}


def write_survey(path: Path, size_bytes: int) -> int:
    """Write a survey of noise of about so many bytes; return how many its numbers have."""
    side = int(np.sqrt(size_bytes / (16 * POINTS * len(ROTATIONS_DEG))))
    shape = (len(ROTATIONS_DEG), side, side, POINTS)
    place_m = STEP_M * np.arange(side)
    frequency_hz = np.linspace(START_HZ, STOP_HZ, POINTS)
    nothing = np.zeros((*shape[:3], 2), dtype=np.complex128)
    described = as_dataset(
        Imported(
            nothing, ROTATIONS_DEG, place_m, place_m, np.full(shape[:3], HEIGHT_M), "noise",
            frequency_hz=frequency_hz[:2],
        )
    )  # fmt: skip
    random = dask.array.random.RandomState(6)
    chunks = (1, ROWS_AT_ONCE, -1, -1)
    numbers = random.standard_normal(shape, chunks=chunks) + 1j
    survey = described.drop_vars(["s21", "frequency"]).assign_coords(frequency=frequency_hz)
    survey = survey.assign(s21=(described.s21.dims, numbers, described.s21.attrs))
    write_dataset(survey, path)
    return int(numbers.nbytes)


def process(survey: Path, steps: List[str], output: Path, limit_bytes: int) -> str:
    """Run the command under a limit; return time and memory, or why it failed."""
    command = [sys.executable, "-m", "gpr20_analysis.commands.main", "process", str(survey)]
    command += [f"--step={step}" for step in steps] + ["-o", str(output), "--overwrite"]

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_DATA, (limit_bytes, limit_bytes))

    started_s = time.monotonic()
    with tempfile.TemporaryFile() as errors:
        running = subprocess.Popen(
            command, preexec_fn=limited, stdout=subprocess.DEVNULL, stderr=errors
        )
        _, status, used = os.wait4(running.pid, 0)
        running.returncode = status
        took_s = time.monotonic() - started_s
        if status:
            errors.seek(0)
            return f"failed: {errors.read().decode().strip().splitlines()[-1]}"
    return f"{took_s:6.1f} s, {used.ru_utime + used.ru_stime:6.1f} s of the processor, " + (
        f"{used.ru_maxrss / KIB_PER_MIB:5.0f} MiB"
    )


def main() -> None:
    """Write the survey and run the chains."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gib", type=float, default=2.0, help="size of the survey's numbers")
    parser.add_argument("--limit-mib", type=int, default=1024, help="memory of the command")
    parser.add_argument("--folder", type=Path, help="where there is space for three surveys")
    parser.add_argument("--ending", choices=(".nc", ".zarr"), default=".nc")
    parser.add_argument("--chains", nargs="+", choices=CHAINS, default=list(CHAINS))
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=chosen.folder) as folder:
        survey = Path(folder) / f"survey{chosen.ending}"
        size = write_survey(survey, int(chosen.gib * 1024 * MIB))
        print(f"{size / MIB:.0f} MiB of numbers, at most {chosen.limit_mib} MiB of memory")
        for name in chosen.chains:
            output = Path(folder) / f"output{chosen.ending}"
            found = process(survey, CHAINS[name], output, chosen.limit_mib * MIB)
            print(f"{name:24s} {found}", flush=True)


if __name__ == "__main__":
    main()
