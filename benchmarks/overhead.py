"""What the software adds to each sample, by stage, when physics takes no time.

    scripts/bench.sh overhead [--rounds N] [--watchers N]

Launches the simulated robot 2,000 times as fast as the real one, with sweeps of 501 points that
take no time and moves of ten steps (0.1 mm), and runs one survey of it through the terminal client:
every trace is stored durably (JSON and MCAP), and all topics are recorded. Printed are the time
from the start of one sweep to the start of the next, and its stages.

On the way from one sweep to the next: `sweep`, from the trigger to its end; `get_data`, from there
to the answer at the main control; `next goal`, from there to the first goal of the next move;
`goal to result` of the axes; `settle`, from there to the request of the sweep; `request`, from
there to the trigger. Beside it: `height`, `confirm` and `store`, each from request to answer, and
`write`, the part of `store` that writes and flushes the files.

With `--watchers N`, each round also measures a robot whose page is watched by N clients over TLS.
"""

from __future__ import annotations

import argparse
import contextlib
import tempfile
import threading
import time
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

from graph_kit import (
    Event,
    Sample,
    events,
    intervals,
    median,
    print_table,
    processor_s,
    run_survey,
    samples,
    tapped_robot,
)
from page_kit import new_page, watchers
from robot_kit import MASTER, NODES, LaunchedRobot

LAUNCH = ("time_scale:=2000", "seconds_per_point:=0")
STEP_MM = 0.1
ROWS = 3
# The first samples fill caches.
WARM_UP = 20
BEGIN_LIMIT_S = 5.0
POLL_S = 0.2
ON_THE_WAY = ("sweep", "get_data", "next goal", "goal to result", "settle", "request")
BESIDE = ("height", "confirm", "store", "write")
Stages = Dict[str, List[float]]


def between(spans: Sequence[Tuple[float, float]], begin_s: float, end_s: float) -> List[float]:
    """Return how long the spans took that began within a time [s]."""
    return [end - begin for begin, end in spans if begin_s <= begin < end_s]


def stages(noted: Sequence[Event], taken: Sequence[Sample]) -> Stages:
    """Return the times of each stage [s]."""
    # The traces have the time of day, the events the monotonic clock.
    offset_s = time.time() - time.monotonic()
    calls = intervals(noted, "call", "get_data")
    goals = intervals(noted, "goal", "")
    found: Stages = {name: [] for name in (*ON_THE_WAY, *BESIDE, "sample")}
    spans = {
        "height": intervals(noted, "call", "get_height"),
        "confirm": intervals(noted, "call", "confirm_data"),
        "store": intervals(noted, "call", "store_data"),
        "write": intervals(noted, "write", "trace"),
    }
    for (asked_s, answered_s), (next_s, _), before, after in zip(
        calls[WARM_UP:], calls[WARM_UP + 1 :], taken[WARM_UP:], taken[WARM_UP + 1 :]
    ):
        started_s = before.started_us * 1e-6 - offset_s
        ended_s = before.ended_us * 1e-6 - offset_s
        moves = [one for one in goals if answered_s <= one[0] < next_s]
        if not moves:
            continue
        first_s, last_s = min(moves)[0], max(end for _begin, end in moves)
        times = {
            "sample": 1e-6 * (after.started_us - before.started_us),
            "request": started_s - asked_s,
            "sweep": ended_s - started_s,
            "get_data": answered_s - ended_s,
            "next goal": first_s - answered_s,
            "goal to result": last_s - first_s,
            "settle": next_s - last_s,
        }
        for name, one_s in times.items():
            found[name].append(one_s)
        for name, some in spans.items():
            found[name] += between(some, asked_s, next_s)
    return found


class ProcessorTimes:
    """The processor time of each process while samples are taken, without homing and set-up."""

    def __init__(self, robot: LaunchedRobot) -> None:
        self._robot = robot
        self._begun = threading.Event()
        self._before: Dict[str, float] = {}
        self._count = 0
        threading.Thread(target=self._wait_for_begin, daemon=True).start()

    def per_sample_s(self) -> Dict[str, float]:
        """Return what each process has used for each sample since the first ones [s].

        Raises:
            SystemExit: The survey was over before.
        """
        if not self._begun.wait(BEGIN_LIMIT_S):
            raise SystemExit("the survey is too short to be measured; give more --columns")
        count = self._stored() - self._count
        return {name: (used_s - self._before[name]) / count for name, used_s in self._now().items()}

    def _wait_for_begin(self) -> None:
        while self._stored() < WARM_UP:
            time.sleep(POLL_S)
        self._before, self._count = self._now(), self._stored()
        self._begun.set()

    def _stored(self) -> int:
        return sum(1 for _ in self._robot.data.glob("*/traces/*.json"))

    def _now(self) -> Dict[str, float]:
        return {name: processor_s(process) for name, process in self._robot.processes().items()}


def measure(columns: int, count: int) -> Stages:
    """Run one survey; return the times of its stages, and the processor's per sample [s].

    Args:
        columns: Stops of each row.
        count: How many watch the page; 0: there is none.
    """
    with contextlib.ExitStack() as stack:
        options: Tuple[str, ...] = LAUNCH
        if count:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="gpr20_page_"))
            page = new_page(Path(folder))
            options = (*LAUNCH, *page.options)
        robot, tap = stack.enter_context(tapped_robot(*options))
        if count:
            stack.enter_context(watchers(page, count))
        stop_mm = 100.0 + STEP_MM * (columns - 1)
        times = ProcessorTimes(robot)
        survey = run_survey(
            robot,
            *("--x-start-mm=100", f"--x-stop-mm={stop_mm:g}", f"--x-points={columns}"),
            *("--y-start-mm=100", f"--y-stop-mm={100 + STEP_MM * (ROWS - 1):g}"),
            *(f"--y-points={ROWS}", "--polarizations-deg=0", "--frequency-points=501"),
        )
        used = {name: [used_s] for name, used_s in times.per_sample_s().items()}
        return {**stages(events(tap), samples(survey)), **used}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=1, help="times that each is measured (1)")
    parser.add_argument("--columns", type=int, default=100, help="stops of each of 3 rows (100)")
    parser.add_argument("--watchers", type=int, default=0, help="of the page, in every other run")
    chosen = parser.parse_args()
    merged: Dict[str, Stages] = {}
    for number in range(chosen.rounds):
        for count in sorted({0, chosen.watchers}):
            label = f"{count} watchers"
            found = measure(chosen.columns, count)
            print(f"round {number + 1}: {label}: {1e3 * median(found['sample']):.2f} ms")
            total = merged.setdefault(label, {name: [] for name in found})
            for name, values in found.items():
                total[name] += values
    print("\nmedians [ms]; the stages from sweep to request follow each other")
    names = ["sample", *ON_THE_WAY, *BESIDE]
    rows = [
        [label, *(f"{1e3 * median(found[name]):.1f}" for name in names)]
        for label, found in merged.items()
    ]
    print_table(["page", *names], rows)
    print("\nprocessor time per sample [ms]")
    processes = [
        [name, *(f"{1e3 * median(found[name]):.2f}" for found in merged.values())]
        for name in (*NODES, MASTER)
    ]
    print_table(["process", *merged], processes)


if __name__ == "__main__":
    main()
