"""Kirchhoff migration by the GPR-20 group's own program and by this one, on the same data.

Usage: scripts/bench.sh group_program --program DIR [--sizes 21 31]

DIR is a checkout of the group's repository, github.com/gdh-uniandes/GPR-Uniandes, which is not part
of this one; its APP-Procesamiento/Funciones/parallel_kirchhoff_migration.py is called as it is. It
needs h5py, numba and numpy before 2.4. Both get the same A-scans of two points, one after the
other, so the load of the machine is about the same; the processor time counts all threads and
processes, without the compilation of the group's loop. The group's depth step follows from its time
step; it has about 25 depths, the phase shift 100.
"""

from __future__ import annotations

import argparse
import importlib.util
import resource
import sys
import time
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, Callable, Dict, List, Tuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from imaging_speed import DEPTH_M, HEIGHT_M, PERMITTIVITY, traces

from gpr20_analysis.imaging.kirchhoff import kirchhoff_image
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_survey.radar.frequency_to_delay import Window

MODULE = Path("APP-Procesamiento", "Funciones", "parallel_kirchhoff_migration.py")


def group_program(checkout: Path) -> ModuleType:
    """Return the group's module for migration."""
    spec = importlib.util.spec_from_file_location(MODULE.stem, checkout / MODULE)
    if spec is None or spec.loader is None or not (checkout / MODULE).is_file():
        raise SystemExit(f"{checkout / MODULE} is missing")
    module = importlib.util.module_from_spec(spec)
    sys.modules[MODULE.stem] = module
    spec.loader.exec_module(module)
    return module


def a_scans(data: Traces) -> Tuple[np.ndarray, float]:
    """Return real A-scans (x, y, delay), as the group's program takes them, and their step [s]."""
    count = data.sweep.count
    bins = 2 * round(data.sweep.frequency_hz[-1] / data.sweep.step_hz)
    spectrum = np.zeros((*data.s21.shape[:2], bins), dtype=np.complex128)
    first = round(data.sweep.start_hz / data.sweep.step_hz)
    spectrum[..., first : first + count] = data.s21 * np.hamming(count)
    scans = np.fft.ifft(spectrum, axis=-1).real.transpose(1, 0, 2)
    return scans, 1.0 / (bins * data.sweep.step_hz)


def took(work: Callable[[], object]) -> Tuple[float, float]:
    """Return time and processor time of this process and its children [s]."""
    begin, busy = time.perf_counter(), _busy_s()
    work()
    return time.perf_counter() - begin, _busy_s() - busy


def _busy_s() -> float:
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in both)


def group_work(module: ModuleType, size: int) -> Callable[[], object]:
    """Return the migration of size x size positions by the group's program."""
    data = traces(size)
    scans, step_s = a_scans(data)
    last_m = float(data.x_m[-1])

    def run() -> None:
        before = module.mp.Pool
        pools: List[Any] = []

        def pool(*arguments: object, **named: object) -> Any:
            pools.append(before(*arguments, **named))
            return pools[-1]

        # It leaves its processes running; the time of children counts only after their end.
        module.mp.Pool = pool
        try:
            module.kirchhoff_migration_3d_parallel(
                scans, HEIGHT_M, PERMITTIVITY, 0.0, step_s * (scans.shape[2] - 0.5), step_s,
                0.0, last_m, size, 0.0, last_m, size, 0.0, float(DEPTH_M[-1]),
            )  # fmt: skip
        finally:
            module.mp.Pool = before
            for one in pools:
                one.close()
                one.join()

    return run


def main(given: List[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=Path, required=True, help="checkout of the group's code")
    parser.add_argument("--sizes", type=int, nargs="+", default=[21, 31])
    chosen = parser.parse_args(given)
    module = group_program(chosen.program)
    # Its worker processes are copies of this one, so they need not compile this.
    module.transmission_angles_2d(PERMITTIVITY, HEIGHT_M, 0.0, 0.1, 0.1)
    print("positions   program           time s  processor s   ratio of processor time")
    for size in chosen.sizes:
        data, focus = traces(size), Focus(PERMITTIVITY, DEPTH_M, window=Window.HAMMING)
        group_s, group_busy_s = took(group_work(module, size))
        print(f"{size:3} x {size:3}   {'group':16}{group_s:8.2f}{group_busy_s:13.2f}")
        methods: Dict[str, Callable[[], object]] = {
            "kirchhoff": partial(kirchhoff_image, data, focus, "xy"),
            "phase-shift": partial(phase_shift_image, data, focus),
        }
        for name, work in methods.items():
            work()
            own_s, busy_s = took(work)
            ratio = group_busy_s / busy_s
            print(f"{size:3} x {size:3}   {name:16}{own_s:8.2f}{busy_s:13.3f}{ratio:10.0f}")


if __name__ == "__main__":
    main(sys.argv[1:])
