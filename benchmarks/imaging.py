"""How long imaging takes and what memory it needs, and its ratio to the group's program.

Usage: scripts/bench.sh imaging [--sizes 67 158 200] [--back-projection-up-to 158] [--chain]
           [--commands]

Each size runs in a process of its own, warm (the best of three runs; the first run, which may
compile the loops, is shown separately). On a machine that does other work as well, the processor
time, which counts all threads, says more than the time. Data: two point targets off the grid, 501
frequencies from 0.6 to 6 GHz, 10 mm step, 100 depths. --commands times `gpr20 import` and `gpr20
image` of 4,489 of the group's CSV files with noise 30 dB below the echoes, in new processes.

The figures of the group's program were measured once, on another machine, with numpy 1.26.4 and
numba 0.68.1: 101 s for the migration of 67 x 67 positions to 32 depths, 127 s from files to image.
So the ratios are of different runs and tell the order of magnitude only.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, List

import numpy as np

from gpr20_analysis.imaging.back_projection import back_projection_image
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.read.load import load_survey
from gpr20_survey.folder import survey_folder, trace_files
from gpr20_survey.radar import one_way_delay_s
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.utc_time import US_PER_S

STEP_M = 0.010
HEIGHT_M = 0.20
PERMITTIVITY = 4.0
SWEEP = FrequencyGrid(600e6, 10.8e6, 501)
DEPTH_M = np.linspace(0.0, 0.297, 100)
GROUP_MIGRATION_S = 101.0
GROUP_CHAIN_S = 127.0
CHAIN_SIZE = 67
RUNS = 3
KIB_PER_MIB = 1024.0
METHODS: Dict[str, Callable[[Traces, Focus], np.ndarray]] = {
    "phase-shift": phase_shift_image,
    "back-projection": back_projection_image,
}


def traces(size: int) -> Traces:
    """Return the echoes of two points over size x size positions."""
    place_m = STEP_M * np.arange(size)
    middle_m = place_m[size // 2]
    s21 = np.zeros((size, size, SWEEP.count), dtype=np.complex128)
    for x_m, y_m, depth_m in ((-0.0737, 0.0512, 0.0833), (0.0866, -0.0421, 0.1571)):
        across_m = np.hypot(place_m[None, :] - middle_m - x_m, place_m[:, None] - middle_m - y_m)
        delay_s = 2.0 * one_way_delay_s(HEIGHT_M, depth_m, across_m, PERMITTIVITY)
        for row in range(size):
            s21[row] += np.exp(-2j * np.pi * delay_s[row][:, None] * SWEEP.frequency_hz)
    return Traces(s21, SWEEP, place_m, place_m, np.full((size, size), HEIGHT_M), 0.0)


def best_s(work: Callable[[], object]) -> Dict[str, float]:
    """Return the time of the first run, and the least time and processor time of others [s]."""
    begin = time.perf_counter()
    work()
    first_s = time.perf_counter() - begin
    times, processor = [], []
    for _ in range(RUNS):
        begin, busy = time.perf_counter(), time.process_time()
        work()
        times.append(time.perf_counter() - begin)
        processor.append(time.process_time() - busy)
    return {"first_s": first_s, "s": min(times), "processor_s": min(processor)}


def peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KIB_PER_MIB


def measure(size: int, method: str) -> Dict[str, float]:
    data, focus = traces(size), Focus(PERMITTIVITY, DEPTH_M)
    took = best_s(lambda: METHODS[method](data, focus))
    return {**took, "peak_mib": peak_mib()}


def measure_chain() -> Dict[str, float]:
    """Time reading 67 x 67 JSON files of one polarization, background and image."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = _survey_files(Path(scratch))
        options = ImageOptions(permittivity=PERMITTIVITY, depth_m=tuple(DEPTH_M))
        took = best_s(lambda: image_survey(remove_background(load_survey(folder)), options))
    return {**took, "peak_mib": peak_mib()}


def _survey_files(scratch: Path) -> Path:
    data = traces(CHAIN_SIZE)
    folder = scratch / "traces"
    folder.mkdir()
    for index, (row, column) in enumerate(np.ndindex(CHAIN_SIZE, CHAIN_SIZE)):
        x_mm, y_mm = data.x_m[column] * 1e3, data.y_m[row] * 1e3
        moment_us = 1_790_000_000_000_000 + index * US_PER_S
        s21 = data.s21[row, column]
        trace = Trace(
            SWEEP.frequency_hz, s21.real.copy(), s21.imag.copy(), moment_us, moment_us,
            (), AnalyzerSettings(), "0f8fad5b-d9cb-469f-a165-70867728950e",
            f"sample-{index}", index, moment_us, x_mm, y_mm, 0.0, HEIGHT_M,
        )  # fmt: skip
        (folder / survey_folder.trace_file_name(trace)).write_bytes(trace_files.encode(trace))
    return folder


def measure_commands() -> Dict[str, float]:
    """Time both commands from 4,489 CSV files to an image, in new processes."""
    random, data = np.random.default_rng(1), traces(CHAIN_SIZE)
    noise = 10.0 ** (-30.0 / 20.0) * random.standard_normal((*data.s21.shape, 2))
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "csv"
        folder.mkdir()
        for row, column in np.ndindex(CHAIN_SIZE, CHAIN_SIZE):
            values = data.s21[row, column] + noise[row, column] @ np.array([1.0, 1j])
            lines = [f"{one.real!r},{one.imag!r}" for one in values.tolist()]
            name = f"VNA_X{10 * column}_Y{10 * row}_OrX_Fs600M_Fe6000M_Qf501_H200.csv"
            (folder / name).write_text("\n".join(["S21_real,S21_imag", *lines, ""]))
        made = str(Path(scratch) / "x.nc")
        gpr20 = [sys.executable, "-m", "gpr20_analysis.commands.main"]
        commands = (
            ["import", str(folder), made, "--format", "group-csv", "--overwrite"],
            ["image", made, "--permittivity", f"{PERMITTIVITY:g}"],
        )

        def run() -> None:
            for command in commands:
                subprocess.run(
                    gpr20 + command,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    check=True,
                )

        took = best_s(run)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    busy_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {**took, "processor_s": busy_s, "peak_mib": after.ru_maxrss / KIB_PER_MIB}


def in_own_process(*arguments: str) -> Dict[str, float]:
    done = subprocess.run(
        [sys.executable, __file__, "--one", *arguments], stdout=subprocess.PIPE, check=True
    )
    result: Dict[str, float] = json.loads(done.stdout)
    return result


def main(given: List[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[31, 67, 100, 158, 200])
    parser.add_argument("--back-projection-up-to", type=int, default=158)
    parser.add_argument("--chain", action="store_true", help="from 4,489 files to the image, too")
    parser.add_argument("--commands", action="store_true", help="from 4,489 CSV files, as commands")
    parser.add_argument("--one", nargs="+", help=argparse.SUPPRESS)
    chosen = parser.parse_args(given)
    if chosen.one:
        method, *size = chosen.one
        others = {"chain": measure_chain, "commands": measure_commands}
        work = others.get(method, lambda: measure(int(size[0]), method))
        print(json.dumps(work()))
        return
    print("method          positions first s   time s  processor s  data MiB  peak MiB  ratio")
    for method in ("phase-shift", "back-projection"):
        for size in chosen.sizes:
            if method == "phase-shift" or size <= chosen.back_projection_up_to:
                show(method, size, in_own_process(method, str(size)), GROUP_MIGRATION_S)
    if chosen.chain:
        show("JSON to image", CHAIN_SIZE, in_own_process("chain"), GROUP_CHAIN_S)
    if chosen.commands:
        show("CSV, commands", CHAIN_SIZE, in_own_process("commands"), GROUP_CHAIN_S)


def show(what: str, size: int, one: Dict[str, float], group_s: float) -> None:
    ratio = f"{group_s / one['s']:6.0f}" if size == CHAIN_SIZE else ""
    data_mib = size**2 * SWEEP.count * 16 / 2**20
    print(
        f"{what:16}{size:3} x {size:3}{one['first_s']:8.2f}{one['s']:9.3f}"
        f"{one['processor_s']:13.3f}{data_mib:10.0f}{one['peak_mib']:10.0f}{ratio}"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
