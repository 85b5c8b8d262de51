"""The robot under the matrix, with a monitor of what was acknowledged."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import List, Optional, Tuple

import rosgraph
from power_cut_disk import PowerCutDisk
from robot_kit import LAUNCH, MASTER, NODES, START_LIMIT_S, LaunchedRobot, end

EVERYTHING = "all processes"
# Any of the nodes, or one of the others.
KINDS = [NODES, [MASTER], [LAUNCH], [EVERYTHING]]
POWER = "power of the disk"
DISK_MIB = 4096
# How long the robot lives on without its disk, and how late the monitor may hear of a trace [s].
WITHOUT_DISK_S = 1.0
LATE_S = 0.5
LAUNCH_FILE = Path(__file__).with_name("probed_survey.launch")
MONITOR_NAME = "/crash_matrix_monitor"
# A trace is published after it was stored, so every trace received was acknowledged.
MONITOR = """
import sys, time, rospy
from gpr20_msgs.msg import Trace
rospy.init_node(sys.argv[2][1:])
def note(trace):
    with open(sys.argv[1], "a") as file:
        file.write(f"{trace.survey_id} {trace.sample_id} {time.monotonic()}\\n")
rospy.Subscriber("trace", Trace, note, queue_size=1000)
rospy.spin()
"""
NEEDED_SERVICES = {
    *("/x_axis/homing", "/y_axis/homing", "/z_axis/homing", "/get_height", "/get_data"),
    *("/store_data", "/start_survey", "/simulator/set_fault"),
}


class MonitoredRobot(LaunchedRobot):
    """The simulated robot, launched again whenever roslaunch or its master was killed.

    Args:
        folder: Where the surveys and the logs are kept.
        time_scale: How many times faster than the real one the robot runs.
        data: The folder of the surveys, if it is another.
    """

    def __init__(self, folder: Path, time_scale: float, data: Optional[Path] = None) -> None:
        super().__init__(folder, f"time_scale:={time_scale:g}", launch=str(LAUNCH_FILE), data=data)
        self._received = folder / "received"
        self._received.touch()
        self._monitor: Optional[subprocess.Popen] = None

    def acknowledged(self, survey_id: str) -> List[str]:
        """Return the sample ids that were acknowledged so far."""
        lines = map(str.split, self._received.read_text().split("\n")[:-1])
        return [
            sample_id
            for one, sample_id, received_s in lines
            if one == survey_id and self._counts(float(received_s))
        ]

    def ensure_running(self) -> None:
        """Launch, unless roslaunch and the master run; return when every node is ready."""
        if MASTER in self.processes():
            return
        self.stop()
        self.start()
        command = [sys.executable, "-c", MONITOR, str(self._received), MONITOR_NAME]
        self._monitor = self.run(command)
        deadline_s = time.monotonic() + START_LIMIT_S
        while not self._is_ready():
            if time.monotonic() > deadline_s:
                raise RuntimeError("the nodes do not get ready")
            time.sleep(0.1)

    def kill(self, name: str) -> bool:
        """Kill a process or all of them; return whether it was there to be killed."""
        if name == EVERYTHING:
            self.kill_all()
            return True
        return super().kill(name)

    def stop(self) -> None:
        """End everything."""
        end(self._monitor, signal.SIGTERM)
        super().stop()

    def _is_ready(self) -> bool:
        with contextlib.suppress(OSError, rosgraph.MasterException):
            _topics, subscribed, services = rosgraph.Master("/crash_matrix").getSystemState()
            listening = (MONITOR_NAME in nodes for topic, nodes in subscribed if topic == "/trace")
            return any(listening) and {name for name, _ in services} >= NEEDED_SERVICES
        return False

    def _counts(self, received_s: float) -> bool:
        return True


class PoweredRobot(MonitoredRobot):
    """The robot with its surveys on a disk whose power can be cut.

    Args:
        folder: Where the disk and the logs are kept.
        time_scale: How many times faster than the real one the robot runs.

    Raises:
        PowerCutError: Such a disk cannot be made here.
    """

    def __init__(self, folder: Path, time_scale: float) -> None:
        self._disk = PowerCutDisk(folder, DISK_MIB)
        self._disk.mount()
        self._cuts: List[Tuple[float, float]] = []
        super().__init__(folder, time_scale, data=self._disk.folder / "data")

    def kill(self, name: str) -> bool:
        """Cut the power of the disk, kill everything soon after, and mount the disk again."""
        if name != POWER:
            return super().kill(name)
        begun_s = time.monotonic()
        self._disk.cut()
        self._cuts.append((begun_s, time.monotonic() + LATE_S))
        # Nothing may be acknowledged meanwhile.
        time.sleep(WITHOUT_DISK_S)
        self.kill_all()
        self._disk.unmount()
        self._disk.mount()
        return True

    def remove_disk(self) -> None:
        """Unmount the disk."""
        self._disk.unmount()

    def _counts(self, received_s: float) -> bool:
        # Without power nobody would have been left to acknowledge what came at the cut.
        return not any(begun_s < received_s < ended_s for begun_s, ended_s in self._cuts)
