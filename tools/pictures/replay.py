"""The window during the replay of a survey."""

from __future__ import annotations

import os
from pathlib import Path

from robot_kit import free_port, running, simulated_robot

from gpr20_user_interface.window.rail import TabName
from pictures.kit import shown_window, wait

SURVEY = ("--x-points=5", "--y-points=5", "--x-start-mm=50", "--y-start-mm=50")
# Traces that are shown before the pictures.
SHOWN = 20


def make(folder: Path) -> None:
    """Record a survey, replay it and take the pictures."""
    with simulated_robot("time_scale:=50") as robot:
        if robot.client(*SURVEY).wait():
            raise SystemExit("the survey did not finish")
        (survey,) = (path.parent for path in robot.data.glob("*/survey.json"))
        robot.stop()
        port = free_port()
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        with running("roscore", "-p", str(port)), shown_window(
            robot.data, replay=True
        ) as shown, running("rosrun", "gpr20_analysis", "replay", "--ns", "/", str(survey)):
            live = shown.window.traces.live
            wait(lambda: live.radar.count >= SHOWN, "traces are shown")
            shown.window.show_tab(TabName.ROBOT)
            shown.take(folder, "replay")
