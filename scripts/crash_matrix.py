"""Kill the nodes of a simulated robot and its ROS master at random instants of surveys.

Every survey is resumed until it is complete, and then everything that was acknowledged is
looked for in its JSON files, its bag and its MCAP. Prints a table and ends with status 1 if
anything was lost, doubled or wrong.

Usage, in the ROS environment: .venv/bin/python scripts/crash_matrix.py [--kills N] [--seed N]
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Counter, Dict, List, Optional

from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

MASTER = "master"
NODES = [
    "x_axis-axis_driver",
    "y_axis-axis_driver",
    "z_axis-axis_driver",
    "height_sensor",
    "vna_acquisition",
    "vna_processing",
    "main_control",
    "simulator",
]
TIME_SCALE = 60
GRID = [
    "--x-start=10",
    "--x-stop=20",
    "--x-points=3",
    "--y-start=10",
    "--y-stop=20",
    "--y-points=3",
]
TRACES = 18
CLIENT_LIMIT_S = 120.0
MOST_RESUMES = 30
FINISHED = 0
MONITOR = """
import sys, rospy
from gpr20_msgs.msg import Trace
rospy.init_node("crash_matrix_monitor", anonymous=True)
def note(trace):
    with open(sys.argv[1], "a") as file:
        file.write(f"{trace.survey_id} {trace.sample_id} {trace.index}\\n")
rospy.Subscriber("trace", Trace, note, queue_size=1000)
rospy.spin()
"""


def free_port() -> int:
    """Return a port of loopback on which nobody listens."""
    import socket

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Robot:
    """The launched system, with a monitor that notes every published, so stored, trace."""

    def __init__(self, folder: Path) -> None:
        self.data = folder / "data"
        self.acknowledged = folder / "acknowledged"
        self._log = (folder / "launch.log").open("ab")
        self._environment = dict(os.environ)
        self._launch: Optional[subprocess.Popen] = None
        self._monitor: Optional[subprocess.Popen] = None

    def ensure_running(self) -> None:
        """Launch, unless it runs."""
        if self._launch is not None and self._launch.poll() is None:
            return
        self.stop()
        port = free_port()
        self._environment["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        self._launch = subprocess.Popen(
            ["roslaunch", "-p", str(port), "gpr20", "survey.launch", "ui:=false"]
            + [f"time_scale:={TIME_SCALE}", f"data:={self.data}"],
            env=self._environment,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._wait_for_nodes()
        self._monitor = subprocess.Popen(
            [sys.executable, "-c", MONITOR, str(self.acknowledged)],
            env=self._environment,
            stdout=self._log,
            stderr=subprocess.STDOUT,
        )

    def client(self, options: List[str]) -> subprocess.Popen:
        """Start the terminal client."""
        return subprocess.Popen(
            ["rosrun", "gpr20_user_interface", "run_survey", *options],
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def kill(self, name: str) -> bool:
        """Kill a node or the master; whether it was there to be killed."""
        pid = self._processes().get(name)
        if pid is None:
            return False
        os.kill(pid, signal.SIGKILL)
        return True

    def stop(self) -> None:
        """End everything."""
        for process, sign in ((self._monitor, signal.SIGTERM), (self._launch, signal.SIGINT)):
            if process is not None and process.poll() is None:
                process.send_signal(sign)
                try:
                    process.wait(60)
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)
        self._launch = self._monitor = None

    def _wait_for_nodes(self) -> None:
        deadline_s = time.monotonic() + 60.0
        while not {*NODES, MASTER} <= set(self._processes()):
            if time.monotonic() > deadline_s:
                raise RuntimeError(f"the robot does not start; see {self._log.name}")
            time.sleep(0.1)

    def _processes(self) -> Dict[str, int]:
        assert self._launch is not None
        found = {}
        listed = subprocess.run(
            ["ps", "-o", "pid=,args=", "--ppid", str(self._launch.pid)],
            capture_output=True,
            text=True,
            check=False,
        )
        for line in listed.stdout.splitlines():
            pid, arguments = line.strip().split(None, 1)
            if "rosmaster" in arguments:
                found[MASTER] = int(pid)
            for name in NODES:
                if f"/{name}-" in arguments:
                    found[name] = int(pid)
        return found


@dataclass
class Result:
    """What the kills did."""

    kills: Counter = field(default_factory=collections.Counter)
    surveys: int = 0
    resumes: int = 0
    acknowledged: int = 0
    faults: List[str] = field(default_factory=list)


def run_client(
    robot: Robot, options: List[str], victim: str, delay_s: float, result: Result
) -> int:
    """Run the client and kill something meanwhile; return the client's exit status."""
    client = robot.client(["--wait", "40", *options])
    if victim:
        try:
            client.wait(delay_s)
        except subprocess.TimeoutExpired:
            if robot.kill(victim):
                result.kills[victim] += 1
    try:
        printed, _nothing = client.communicate(timeout=CLIENT_LIMIT_S)
    except subprocess.TimeoutExpired:
        client.kill()
        result.faults.append(f"the client hung after {victim} was killed")
        return -1
    if client.returncode != FINISHED:
        print(f"    status {client.returncode}: {printed.strip().splitlines()[-3:]}", flush=True)
    return client.returncode


def newest_survey(robot: Robot, known: List[Path]) -> Optional[Path]:
    """Return the folder of the survey that was begun last, if it is not a known one."""
    folders = [path for path in robot.data.glob("*_*") if path not in known]
    return folders[0] if folders else None


def run_survey(robot: Robot, chance: random.Random, result: Result, known: List[Path]) -> None:
    """Begin a survey, kill and resume until it is complete, and check it."""
    options = list(GRID)
    folder: Optional[Path] = None
    for attempt in range(MOST_RESUMES):
        robot.ensure_running()
        victim = chance.choice([*NODES, MASTER]) if attempt < 4 else ""
        status = run_client(robot, options, victim, chance.uniform(0.3, 4.0), result)
        folder = folder or newest_survey(robot, known)
        if status == FINISHED and folder is not None:
            break
        if folder is not None:
            result.resumes += 1
            options = ["--resume", folder.name]
    else:
        result.faults.append(f"{folder} was not complete after {MOST_RESUMES} resumes")
    if folder is not None:
        known.append(folder)
        result.surveys += 1
        check_survey(folder, robot.acknowledged, result)


def check_survey(folder: Path, acknowledged: Path, result: Result) -> None:
    """Look for every acknowledged trace, and for anything doubled or wrong."""
    stored = [json.loads(path.read_text()) for path in sorted(folder.glob("traces/*.json"))]
    by_sample = {one["sample_id"]: one for one in stored}
    if sorted(one["index"] for one in stored) != list(range(TRACES)):
        result.faults.append(f"{folder.name}: {len(stored)} traces, not each of {TRACES} once")
    places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
    planned = {
        (x, y, z) for x in (10.0, 15.0, 20.0) for y in (10.0, 15.0, 20.0) for z in (0.0, 90.0)
    }
    if places != planned:
        result.faults.append(f"{folder.name}: coordinates {sorted(places ^ planned)[:3]}")
    recorded = {
        "bag": bag_traces(folder / "survey.bag"),
        "mcap": mcap_traces(folder / "survey.mcap"),
    }
    for kind, traces in recorded.items():
        if collections.Counter(traces) != collections.Counter(list(by_sample)):
            result.faults.append(
                f"{folder.name}: the {kind} holds other traces than the JSON files"
            )
    survey_id = json.loads((folder / "survey.json").read_text())["survey_id"]
    lines = acknowledged.read_text().split("\n") if acknowledged.exists() else []
    for line in lines:
        if line.startswith(survey_id):
            result.acknowledged += 1
            if line.split()[1] not in by_sample:
                result.faults.append(f"{folder.name}: acknowledged and lost: {line}")


def bag_traces(path: Path) -> List[str]:
    """Return the sample ids in a bag, by a reader that is not the writer."""
    with AnyReader([path]) as reader:
        connections = [one for one in reader.connections if one.topic == "/trace"]
        return [
            reader.deserialize(raw, connection.msgtype).sample_id
            for connection, _time, raw in reader.messages(connections)
        ]


def mcap_traces(path: Path) -> List[str]:
    """Return the sample ids in an MCAP."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [
            message.sample_id
            for _schema, _channel, _raw, message in reader.iter_decoded_messages(topics=["/trace"])
        ]


def main() -> int:
    """Run the matrix; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=200, help="at least so many kills")
    parser.add_argument("--seed", type=int, default=20, help="of the random instants")
    arguments = parser.parse_args()
    chance, result, known = random.Random(arguments.seed), Result(), []
    folder = Path(tempfile.mkdtemp(prefix="gpr20_crash_matrix_"))
    robot = Robot(folder)
    begin_s = time.monotonic()
    try:
        while sum(result.kills.values()) < arguments.kills:
            run_survey(robot, chance, result, known)
            print(
                f"  {sum(result.kills.values())} kills, {result.surveys} surveys, "
                f"{result.resumes} resumes, {len(result.faults)} faults",
                flush=True,
            )
    finally:
        robot.stop()
    print(f"\n{'killed':24}{'times':>6}")
    for name, times in sorted(result.kills.items()):
        print(f"{name:24}{times:6}")
    print(
        f"{sum(result.kills.values())} kills in {time.monotonic() - begin_s:.0f} s, "
        f"{result.surveys} surveys, {result.resumes} resumes, {result.acknowledged} acknowledged "
        f"traces, {len(result.faults)} faults"
    )
    for fault in result.faults:
        print("FAULT:", fault)
    if result.faults:
        print(f"everything is kept in {folder}")
        return 1
    shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
