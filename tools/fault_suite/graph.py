"""Kill -9 of processes of the simulated robot, in surveys that are resumed until they are whole."""

from __future__ import annotations

import base64
import contextlib
import itertools
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, Iterator, List, Optional, Set

from robot_kit import LAUNCH, MASTER, NODES, LaunchedRobot, end

from fault_suite.accidents import Accident, Course
from fault_suite.judge import Became, Finding, Judge, Ledger, verdict_of
from gpr20_analysis.read.verdict import COMPLETE
from gpr20_simulator.mid.world.medium import probed_position_mm, probed_rotation_deg
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.trace import trace_message

EVERYTHING = "everything"
# A node as often as each of the others.
VICTIMS = (NODES, ["rosout"], [MASTER], [LAUNCH], [EVERYTHING])
# The instrument answers with the place and the rotation at which each number was measured.
ARGUMENTS = ("time_scale:=60", "vna_medium:=position_probe")
START = ["--wait=20", "--site=A garden", "--x-start=10", "--x-stop=20", "--x-points=3"]
START += ["--y-start=10", "--y-stop=20", "--y-points=3"]
PLANNED = sorted(itertools.product((10.0, 15.0, 20.0), (10.0, 15.0, 20.0), (0.0, 90.0)))
# From the start of the client, most often within such a survey [s].
MOMENT_S = (0.3, 5.0)
CLIENT_LIMIT_S = 120.0
KILLS_PER_SURVEY, MOST_RESUMES = 4, 40
# The answer gives the rotation to 0.4 degrees; a step of the motor is 1.8 degrees.
TOLERANCE_DEG = 0.9
# Both topics are published when they are durable, so what is received was acknowledged.
MONITOR = """
import base64, sys, rospy
file = open(sys.argv[1], "ab", 0)
def note(topic):
    take = lambda one: file.write(f"{topic} {base64.b64encode(one._buff).decode()}\\n".encode())
    rospy.Subscriber(topic, rospy.AnyMsg, take, queue_size=1000)
rospy.init_node("fault_suite_monitor")
note("trace")
note("survey_log")
rospy.spin()
"""


class RobotKills:
    """The robot, which runs surveys and is killed meanwhile."""

    def __init__(self, place: Path) -> None:
        place.mkdir()
        self._robot = LaunchedRobot(place, *ARGUMENTS)
        self._heard, self._output = place / "heard", (place / "client.log").open("ab")
        self._monitor: Optional[subprocess.Popen] = None

    def __enter__(self) -> Accident:
        return self.survey

    def survey(self, course: Course) -> None:
        """Begin a survey, kill and resume until it is whole, and judge it."""
        chance, ledger, judge = course.chance, course.ledger, Judge(course.result, course.name)
        # Right is what the monitor hears.
        ledger.opened, ledger.expected = True, {}
        self._heard.write_bytes(b"")
        before, options = self._folders(), START
        for attempt in range(MOST_RESUMES):
            self._ensure_running()
            victim = chance.choice(chance.choice(VICTIMS)) if attempt < KILLS_PER_SURVEY else ""
            try:
                is_killed = self._run_client(options, victim, chance.uniform(*MOMENT_S))
                course.result.sorts[victim] += is_killed
            except subprocess.TimeoutExpired as error:
                judge.note([(Became.STUCK, f"{victim or 'nothing'} was killed: {error}")])
            for folder in self._folders() - before:
                if verdict_of(folder)[0] == COMPLETE:
                    judge.note(self._log_findings(folder, ledger))
                    for trace in map(read_trace, folder.glob("traces/*.json")):
                        ledger.expected.setdefault(trace.index, trace)
                    judge.check(folder, ledger, is_finished=True)
                    judge.note(_place_findings(ledger))
                    return
                options = ["--wait=20", "--resume", folder.name]
        judge.note([(Became.STUCK, f"not whole after {MOST_RESUMES} resumes")])

    def __exit__(self, *_error: Any) -> None:
        end(self._monitor, signal.SIGTERM)
        self._robot.stop()

    def _folders(self) -> Set[Path]:
        return set(self._robot.data.glob("[0-9]*_*"))

    def _ensure_running(self) -> None:
        """Launch, unless roslaunch and the master run."""
        if MASTER not in self._robot.processes():
            self.__exit__()
            self._robot.start()
            self._monitor = self._robot.run([sys.executable, "-c", MONITOR, str(self._heard)])

    def _run_client(self, options: List[str], victim: str, after_s: float) -> bool:
        """Run the client and kill meanwhile; return whether it had not ended then."""
        client = self._robot.client(*options, stdout=self._output, stderr=self._output)
        try:
            with contextlib.suppress(subprocess.TimeoutExpired):
                client.wait(after_s if victim else CLIENT_LIMIT_S)
            is_running = client.poll() is None
            if is_running and victim == EVERYTHING:
                self._robot.kill_all()
                client.kill()
            elif is_running:
                self._robot.kill(victim)
            client.wait(CLIENT_LIMIT_S)
            return is_running
        finally:
            client.kill()

    def _log_findings(self, folder: Path, ledger: Ledger) -> Iterator[Finding]:
        """Note the traces that the monitor heard; yield what the log lacks of what it heard."""
        for topic, coded in map(bytes.split, self._heard.read_bytes().splitlines()):
            data = base64.b64decode(coded)
            if topic == b"trace":
                trace = trace_message.decode(data, trace_message.MD5SUM)
                ledger.expected[trace.index] = trace
                ledger.stored.add(trace.index)
            for path in folder.glob("log*.jsonl") if topic == b"survey_log" else ():
                # Behind the length of the text.
                if path.read_bytes().splitlines().count(data[4:]) != 1:
                    yield Became.LOST, f"{data[4:]!r} in {path.name}"


def _place_findings(ledger: Ledger) -> Iterator[Finding]:
    """Yield what was not measured once at each place of the plan, and there."""
    traces = ledger.expected.values()
    places = [(one.x_coord_mm, one.y_coord_mm, one.z_coord_deg) for one in traces]
    if sorted(places) != PLANNED:
        yield Became.MOVED, f"{places} are not the places of the plan"
    for trace, (x_mm, y_mm, rotation_deg) in zip(traces, places):
        value, *others = {complex(*one) for one in zip(trace.s21_real, trace.s21_imag)}
        off_deg = abs(probed_rotation_deg(value) - rotation_deg)
        if others or probed_position_mm(value) != (x_mm, y_mm) or off_deg > TOLERANCE_DEG:
            yield Became.MOVED, f"trace {trace.index} was measured elsewhere"
