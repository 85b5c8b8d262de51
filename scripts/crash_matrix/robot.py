"""The launched system under the matrix: its processes, and a monitor of what was acknowledged."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Dict, List, Optional

import psutil

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
# Everything at once, as when the power fails.
POWER = "all at once"
VICTIMS = [*NODES, MASTER, POWER]
START_LIMIT_S = 60.0
END_LIMIT_S = 60.0
LAUNCH_FILE = Path(__file__).with_name("probed_survey.launch")
# A trace is published after it was stored, so whatever is heard was acknowledged.
MONITOR = """
import sys, rospy
from gpr20_msgs.msg import Trace
rospy.init_node("crash_matrix_monitor", anonymous=True)
def note(trace):
    with open(sys.argv[1], "a") as file:
        file.write(f"{trace.survey_id} {trace.sample_id}\\n")
rospy.Subscriber("trace", Trace, note, queue_size=1000)
rospy.spin()
"""


def free_port() -> int:
    """Return a port of loopback on which nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Robot:
    """The simulated robot, launched again whenever its master was killed.

    Args:
        folder: Where the surveys and the logs are kept.
        time_scale: How many times faster than the real one the robot runs.
    """

    def __init__(self, folder: Path, time_scale: float) -> None:
        self.data = folder / "data"
        self._time_scale = time_scale
        self._acknowledged = folder / "acknowledged"
        self._acknowledged.touch()
        self._log = (folder / "launch.log").open("ab")
        self._environment = dict(os.environ)
        self._launch: Optional[subprocess.Popen] = None
        self._monitor: Optional[subprocess.Popen] = None

    def acknowledged(self, survey_id: str) -> List[str]:
        """Return the sample ids that were acknowledged so far."""
        lines = self._acknowledged.read_text().split("\n")[:-1]
        return [line.split()[1] for line in lines if line.startswith(survey_id)]

    def ensure_running(self) -> None:
        """Launch, unless it runs with its master."""
        if self._launch is not None and MASTER in self._processes():
            return
        self.stop()
        port = free_port()
        self._environment["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        self._launch = self._start(
            ["roslaunch", "-p", str(port), str(LAUNCH_FILE)]
            + [f"time_scale:={self._time_scale:g}", f"data:={self.data}"]
        )
        self._wait_for_nodes()
        self._monitor = self._start([sys.executable, "-c", MONITOR, str(self._acknowledged)])

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
        """Kill a node, the master or everything; return whether it was there to be killed."""
        if name == POWER:
            return self._kill_everything()
        pid = self._processes().get(name)
        if pid is None:
            return False
        os.kill(pid, signal.SIGKILL)
        return True

    def _kill_everything(self) -> bool:
        assert self._launch is not None
        launch = psutil.Process(self._launch.pid)
        # Stopped first, so that nothing is started anew meanwhile.
        launch.suspend()
        for process in [*launch.children(recursive=True), launch]:
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()
        self._launch.wait()
        return True

    def stop(self) -> None:
        """End everything."""
        for process, sign in ((self._monitor, signal.SIGTERM), (self._launch, signal.SIGINT)):
            if process is not None and process.poll() is None:
                process.send_signal(sign)
                try:
                    process.wait(END_LIMIT_S)
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)
        self._launch = self._monitor = None

    def _start(self, command: List[str]) -> subprocess.Popen:
        return subprocess.Popen(
            command,
            env=self._environment,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def _wait_for_nodes(self) -> None:
        deadline_s = time.monotonic() + START_LIMIT_S
        while not {*NODES, MASTER} <= set(self._processes()):
            if time.monotonic() > deadline_s:
                raise RuntimeError(f"the robot does not start; see {self._log.name}")
            time.sleep(0.1)

    def _processes(self) -> Dict[str, int]:
        """Return the processes that roslaunch started, by name."""
        assert self._launch is not None
        words = {MASTER: "rosmaster", **{name: f"/{name}-" for name in NODES}}
        found = {}
        for child in children_of(self._launch.pid):
            try:
                line = " ".join(child.cmdline())
            except (psutil.NoSuchProcess, psutil.ZombieProcess):
                continue
            found.update({name: child.pid for name, word in words.items() if word in line})
        return found


def children_of(pid: int) -> List[psutil.Process]:
    """Return the children of a process; none if it has ended."""
    try:
        return psutil.Process(pid).children()
    except psutil.NoSuchProcess:
        return []
