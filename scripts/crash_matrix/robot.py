"""The robot under the matrix, with a monitor of what was acknowledged."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path
from typing import List, Optional

from robot_kit import MASTER, NODES, LaunchedRobot, end

# Everything at once, as when the power fails.
POWER = "all at once"
VICTIMS = [*(name for name in NODES if name != "rosout"), MASTER, POWER]
LAUNCH_FILE = Path(__file__).with_name("probed_survey.launch")
# A trace is published after it was stored, so every trace received was acknowledged.
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


class MonitoredRobot(LaunchedRobot):
    """The simulated robot, launched again whenever its master was killed.

    Args:
        folder: Where the surveys and the logs are kept.
        time_scale: How many times faster than the real one the robot runs.
    """

    def __init__(self, folder: Path, time_scale: float) -> None:
        super().__init__(folder, f"time_scale:={time_scale:g}", launch=str(LAUNCH_FILE))
        self._acknowledged = folder / "acknowledged"
        self._acknowledged.touch()
        self._monitor: Optional[subprocess.Popen] = None

    def acknowledged(self, survey_id: str) -> List[str]:
        """Return the sample ids that were acknowledged so far."""
        lines = self._acknowledged.read_text().split("\n")[:-1]
        return [line.split()[1] for line in lines if line.startswith(survey_id)]

    def ensure_running(self) -> None:
        """Launch, unless it runs with its master."""
        if MASTER not in self.processes():
            self.stop()
            self.start()
            self._monitor = self.run([sys.executable, "-c", MONITOR, str(self._acknowledged)])

    def kill(self, name: str) -> bool:
        """Kill a node, the master or everything; return whether it was there to be killed."""
        if name == POWER:
            self.kill_all()
            return True
        return super().kill(name)

    def stop(self) -> None:
        """End everything."""
        end(self._monitor, signal.SIGTERM)
        super().stop()
