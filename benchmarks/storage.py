"""Store 25,000 traces of 501 points in one survey and watch the storage's time and memory.

Starts its own master and its own vna_processing on loopback, drives `store_data` as fast as
it answers, and prints a table. The survey is then stopped, opened again by a new node, and
verified. Everything lies in a temporary folder that is removed afterwards.

    scripts/bench.sh storage [--x-points 125 --y-points 100] [--folder DIR]
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import uuid
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import rospy
from recorded_survey_kit import TRAVEL, described
from robot_kit import free_port, resident_mib, running
from std_msgs.msg import Header

from gpr20_msgs.msg import Trace
from gpr20_msgs.srv import CloseSurvey, OpenSurvey, ReopenSurvey, StoreData
from gpr20_survey.axes import ANTENNA_LINK
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_points import SurveyPoint, survey_points

ROOT = Path(__file__).resolve().parents[1]
NODE = ROOT / "catkin_ws/src/gpr20_vna_processing/nodes/vna_processing"
VERIFY = ROOT / "scripts/verify.sh"
TIME_LIMIT_S = 60.0
POINTS = 501
BYTES_PER_TRACE = 70_000  # JSON, bag and MCAP
ALLOWED_GROWTH_BYTES = 2000  # of memory per trace: the indexes of the recordings


class Traces:
    """Makes traces of noise, which is the hardest to store."""

    def __init__(self, survey_id: str) -> None:
        self._survey_id = survey_id
        self._random = np.random.default_rng(20)
        self._frequencies = np.linspace(6e8, 6e9, POINTS).tolist()

    def make(self, point: SurveyPoint) -> Trace:
        """Return the trace of a planned point."""
        now = rospy.Time.from_sec(time.time())
        real, imag = self._random.standard_normal((2, POINTS)) * 1e-3
        return Trace(
            header=Header(stamp=now, frame_id=ANTENNA_LINK),
            format="gpr20-trace/1",
            survey_id=self._survey_id,
            sample_id=str(uuid.uuid4()),
            index=point.index,
            timestamp=now,
            x_coord_mm=point.x_mm,
            y_coord_mm=point.y_mm,
            z_coord_deg=point.z_deg,
            antennae_height_m=0.1,
            frequency_hz=self._frequencies,
            s21_real=real.tolist(),
            s21_imag=imag.tolist(),
            sweep_started=now,
            sweep_ended=now,
        )


def store_all(
    store: Any, traces: Traces, points: List[SurveyPoint], node: int, marks: List[int]
) -> List[Dict[str, float]]:
    """Store every point; return a row of the table per mark."""
    rows: List[Dict[str, float]] = []
    times_ms: List[float] = []
    begin_s = time.monotonic()
    for count, point in enumerate(points, 1):
        message = traces.make(point)
        start_s = time.monotonic()
        answer = store(message)
        times_ms.append((time.monotonic() - start_s) * 1e3)
        if not answer.success:
            raise RuntimeError(answer.message)
        if count in marks:
            ordered = sorted(times_ms)
            rows.append(
                {
                    "count": count,
                    "rss_mib": resident_mib(node),
                    "median_ms": statistics.median(ordered),
                    "p95_ms": ordered[int(0.95 * len(ordered))],
                    "per_s": count / (time.monotonic() - begin_s),
                }
            )
            print(rows[-1], file=sys.stderr, flush=True)
            times_ms.clear()
        elif len(times_ms) > 1000:
            del times_ms[0]  # a row reports the 1,000 stores before it
    return rows


def table(rows: List[Dict[str, float]]) -> str:
    lines = [
        "| traces stored | memory of the node [MiB] | median store [ms] | 95 % of stores [ms] | "
        "stores per second since the start |",
        "| ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in rows:
        lines.append(
            f"| {row['count']:,.0f} | {row['rss_mib']:.1f} | {row['median_ms']:.1f} | "
            f"{row['p95_ms']:.1f} | {row['per_s']:.0f} |"
        )
    return "\n".join(lines)


def sizes(folder: Path) -> str:
    parts = [("survey.mcap", (folder / "survey.mcap").stat().st_size)]
    parts.append(("traces/", sum(one.stat().st_size for one in (folder / "traces").iterdir())))
    return ", ".join(f"{name} {size / 1e6:,.0f} MB" for name, size in parts)


def start_node(data: Path) -> Any:
    own = {"GPR20_DATA": str(data), "GPR20_STATE": f"{data}.state"}
    return running(sys.executable, str(NODE), env={**os.environ, **own})


def service(name: str, kind: Any) -> Any:
    rospy.wait_for_service(name, TIME_LIMIT_S)
    return rospy.ServiceProxy(name, kind)


def run(data: Path, parameters: SurveyParameters) -> bool:
    points = survey_points(parameters, TRAVEL)
    step = max(1, len(points) // 5)
    first = 1000 if len(points) > 5000 else step
    marks = sorted({first, *range(step, len(points) + 1, step), len(points)})
    survey_id = str(uuid.uuid4())
    with start_node(data) as node:
        opened = service("open_survey", OpenSurvey)(
            survey_id=survey_id,
            started=rospy.Time.from_sec(time.time()),
            metadata_json=json.dumps(described(parameters, len(points))),
            needed_bytes=len(points) * BYTES_PER_TRACE,
        )
        if not opened.success:
            raise RuntimeError(opened.message)
        rospy.wait_for_service("store_data", TIME_LIMIT_S)
        store = rospy.ServiceProxy("store_data", StoreData, persistent=True)
        rows = store_all(store, Traces(survey_id), points, node.pid, marks)
        close = service("close_survey", CloseSurvey)
        closing_s = seconds(lambda: close(survey_id=survey_id, outcome="stopped", reason="end"))
    folder = Path(opened.path)
    print(table(rows))
    print(f"\nClosing, with the indexes and the manifest: {closing_s:.1f} s. {sizes(folder)}.")
    with start_node(data):
        reopen = service("reopen_survey", ReopenSurvey)
        reopening_s = seconds(lambda: reopen(survey=survey_id))
        print(f"Reopening, with every trace read from JSON and MCAP: {reopening_s:.1f} s.")
        finish = service("close_survey", CloseSurvey)
        seconds(lambda: finish(survey_id=survey_id, outcome="finished", reason="end"))
    verifying_s = seconds(lambda: subprocess.run([str(VERIFY), str(folder)], check=True))
    print(f"Verifying: {verifying_s:.1f} s.")
    grown_mib = rows[-1]["rss_mib"] - rows[0]["rss_mib"]
    growth_bytes = grown_mib * (1 << 20) / (rows[-1]["count"] - rows[0]["count"])
    print(
        f"Memory from {rows[0]['count']:,} to {rows[-1]['count']:,} traces: {grown_mib:+.1f} MiB, "
        f"{growth_bytes:.0f} bytes per trace."
    )
    return growth_bytes <= ALLOWED_GROWTH_BYTES


def seconds(work: Any) -> float:
    """Return how long a call took [s]; its answer must not be a refusal."""
    start_s = time.monotonic()
    answer = work()
    if not getattr(answer, "success", True):
        raise RuntimeError(answer.message)
    return time.monotonic() - start_s


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--x-points", type=int, default=125)
    options.add_argument("--y-points", type=int, default=100)
    options.add_argument("--folder", default=tempfile.gettempdir())
    chosen = options.parse_args()
    parameters = SurveyParameters(
        "127.0.0.1", 6e8, 6e9, POINTS,
        0.0, 650.0, chosen.x_points, 0.0, 800.0, chosen.y_points,
    )  # fmt: skip
    needed = parameters.total_points * BYTES_PER_TRACE
    free = shutil.disk_usage(chosen.folder).free
    if free < 2 * needed:
        print(f"{chosen.folder} has {free / 1e6:.0f} MB; {2 * needed / 1e6:.0f} MB are needed")
        return 2
    port = free_port()
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    with tempfile.TemporaryDirectory(dir=chosen.folder) as data, running(
        "roscore", "-p", str(port)
    ):
        # Waits for the master.
        rospy.init_node("storage_benchmark", disable_signals=True)
        return 0 if run(Path(data), parameters) else 1


if __name__ == "__main__":
    sys.exit(main())
