"""Kill the processes of a simulated robot, and cut the power of its disk, in the middle of surveys.

Process kills: kill -9 of a node, of rosout, of the ROS master, of roslaunch or of all processes.
Power cuts: the file system with the surveys is shut down without flushing its log; then all
processes are killed, and the file system is mounted again. Both come at random instants; the first
process kills are one of each kind, the others any.

Every survey is resumed until it is complete. After each kill or cut a copy of the files must hold
every acknowledged trace after the stock repair; in the end everything that was acknowledged is
looked for in the JSON files, the bag and the MCAP, and every trace must have been measured at the
place and the rotation that it says. Prints a table for each. Ends with status 1 if anything was
lost, doubled or wrong, with 77 where power cuts are asked for and not possible.

Usage, in the ROS environment: python tools/crash_matrix [--kills N] [--power-cuts N] [--seed N]
"""

from __future__ import annotations

import argparse
import collections
import itertools
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Counter, List, Optional, Sequence

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "kits"))

from evidence import faults_after_a_kill, faults_in_the_end, outcome_of, survey_id_of
from power_cut_disk import PowerCutError, check, hide_mounts
from robot import EVERYTHING, KINDS, POWER, MonitoredRobot, PoweredRobot

TIME_SCALE = 60.0
PLACES_MM = (10.0, 15.0, 20.0)
ROTATIONS_DEG = (0.0, 90.0)
PLANNED = set(itertools.product(PLACES_MM, PLACES_MM, ROTATIONS_DEG))
GRID = [
    f"--{axis}-{name}={value:g}"
    for axis in "xy"
    for name, value in (("start", PLACES_MM[0]), ("stop", PLACES_MM[-1]), ("points", 3))
]
# From the start of the client, or from its first request, to the end of such a survey, most often.
AFTER_START_S = (0.3, 4.0)
AFTER_REQUEST_S = (0.0, 2.5)
FROM_REQUEST = 0.5  # how often it is counted from there
CLIENT_LIMIT_S = 120.0
NODES_LIMIT_S = 20
KILLS_PER_SURVEY = 4
MOST_RESUMES = 30
FINISHED = 0
NOT_POSSIBLE = 77


@dataclass
class Result:
    """What the kills or cuts did."""

    kills: Counter = field(default_factory=collections.Counter)
    surveys: int = 0
    resumes: int = 0
    acknowledged: int = 0
    copies: int = 0
    faults: List[str] = field(default_factory=list)


class Matrix:
    """Runs surveys and kills meanwhile.

    Args:
        robot: Runs the surveys.
        kinds: What may be killed or cut, by its kind.
        chance: Chooses victims and instants.
        output: A file for what the client prints.
    """

    def __init__(
        self,
        robot: MonitoredRobot,
        kinds: Sequence[Sequence[str]],
        chance: random.Random,
        output: Path,
    ) -> None:
        self.result = Result()
        self._robot = robot
        self._victims = [victim for kind in kinds for victim in kind]
        self._chance = chance
        self._first = [chance.choice(kind) for kind in kinds]
        self._output = output
        self._known: List[Path] = []

    def run_survey(self) -> None:
        """Begin a survey, kill and resume until it is complete, and check it."""
        options, folder = GRID, None
        for attempt in range(MOST_RESUMES):
            self._robot.ensure_running()
            victim = self._next_victim() if attempt < KILLS_PER_SURVEY else None
            status = self._run_client(options, victim)
            folder = folder or self._new_folder()
            if folder is not None:
                # A client whose control was killed in the last moment cannot know that it ended.
                if status == FINISHED or outcome_of(folder) == "finished":
                    break
                self.result.resumes += 1
                options = ["--resume", folder.name]
        else:
            self.result.faults.append(f"{folder} was not complete after {MOST_RESUMES} resumes")
        if folder is not None:
            self._known.append(folder)
            self._check(folder)

    def _next_victim(self) -> str:
        return self._first[0] if self._first else self._chance.choice(self._victims)

    def _run_client(self, options: List[str], victim: Optional[str]) -> int:
        with self._output.open("w") as output:
            client = self._robot.client(
                *("--wait", str(NODES_LIMIT_S), *options), stdout=output, stderr=subprocess.STDOUT
            )
        if victim is not None and self._is_moment(client, victim):
            self._kill(victim)
            if victim in (POWER, EVERYTHING):
                client.kill()
        try:
            client.wait(CLIENT_LIMIT_S)
        except subprocess.TimeoutExpired:
            client.kill()
            self.result.faults.append(f"the client hung after {victim} was killed")
            return -1
        if client.returncode != FINISHED:
            printed = self._output.read_text().strip().splitlines()[-3:]
            print(f"    status {client.returncode}: {printed}", flush=True)
        return client.returncode

    def _is_moment(self, client: subprocess.Popen, victim: str) -> bool:
        """Wait for a random moment of a survey; return False if the client ended before."""
        # A power cut matters only while something is written.
        if victim == POWER or self._chance.random() < FROM_REQUEST:
            while client.poll() is None and not self._output.stat().st_size:
                time.sleep(0.02)
            delay_s = self._chance.uniform(*AFTER_REQUEST_S)
        else:
            delay_s = self._chance.uniform(*AFTER_START_S)
        try:
            client.wait(delay_s)
        except subprocess.TimeoutExpired:
            return True
        return False

    def _kill(self, victim: str) -> None:
        if not self._robot.kill(victim):
            return
        self.result.kills[victim] += 1
        # Until then it was to be killed again: a client may end before its moment.
        if victim in self._first:
            self._first.remove(victim)
        folder = self._new_folder()
        if folder is not None:
            self.result.copies += 1
            acknowledged = self._robot.acknowledged(survey_id_of(folder))
            self.result.faults += faults_after_a_kill(folder, acknowledged)

    def _new_folder(self) -> Optional[Path]:
        """Return the folder of the survey that was begun last, if it is not a known one."""
        metadata = [path.parent for path in self._robot.data.glob("*_*/survey.json")]
        return next((path for path in metadata if path not in self._known), None)

    def _check(self, folder: Path) -> None:
        acknowledged = self._robot.acknowledged(survey_id_of(folder))
        self.result.surveys += 1
        self.result.acknowledged += len(acknowledged)
        self.result.faults += faults_in_the_end(folder, acknowledged, PLANNED)


def run_matrix(matrix: Matrix, count: int, name: str) -> List[str]:
    """Kill or cut at least so many times; print the table and return the faults."""
    result, begin_s = matrix.result, time.monotonic()
    while sum(result.kills.values()) < count:
        matrix.run_survey()
        print(
            f"  {sum(result.kills.values())} {name}, {result.surveys} surveys, "
            f"{result.resumes} resumes, {len(result.faults)} faults",
            flush=True,
        )
    print(f"\n{name:24}{'times':>6}")
    for victim, times in sorted(result.kills.items()):
        print(f"{victim:24}{times:6}")
    print(
        f"{sum(result.kills.values())} {name} in {time.monotonic() - begin_s:.0f} s, "
        f"{result.surveys} surveys, {result.resumes} resumes, {result.copies} copies examined, "
        f"{result.acknowledged} acknowledged traces, {len(result.faults)} faults"
    )
    for fault in result.faults:
        print("FAULT:", fault)
    return result.faults


def kill_processes(folder: Path, count: int, seed: int) -> List[str]:
    """Kill processes; return the faults."""
    robot = MonitoredRobot(folder, TIME_SCALE)
    try:
        matrix = Matrix(robot, KINDS, random.Random(seed), folder / "client.log")
        return run_matrix(matrix, count, "process kills")
    finally:
        robot.stop()


def cut_power(folder: Path, count: int, seed: int) -> List[str]:
    """Cut the power of the disk; return the faults."""
    robot = PoweredRobot(folder, TIME_SCALE)
    try:
        matrix = Matrix(robot, [[POWER]], random.Random(seed), folder / "client.log")
        faults = run_matrix(matrix, count, "power cuts")
        if faults:
            shutil.copytree(str(robot.data), str(folder / "data"))
    finally:
        robot.stop()
        robot.remove_disk()
    return faults


def main() -> int:
    """Run the matrix; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=200, help="at least so many process kills")
    parser.add_argument("--power-cuts", type=int, default=0, help="at least so many, needs root")
    parser.add_argument("--seed", type=int, default=20, help="of the random instants")
    arguments = parser.parse_args()
    if arguments.power_cuts:
        try:
            hide_mounts()
            check()
        except PowerCutError as error:
            print(f"no power cuts here: {error}")
            return NOT_POSSIBLE
    folder = Path(tempfile.mkdtemp(prefix="gpr20_crash_matrix_"))
    # The robot must not outlive the script, however it ends.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))
    faults = []
    for name, run, count in (
        ("kills", kill_processes, arguments.kills),
        ("cuts", cut_power, arguments.power_cuts),
    ):
        if count:
            (folder / name).mkdir()
            faults += run(folder / name, count, arguments.seed)
    if faults:
        print(f"everything is kept in {folder}")
        return 1
    shutil.rmtree(str(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main())
