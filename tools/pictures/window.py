"""Every tab of the window during a survey."""

from __future__ import annotations

from pathlib import Path

from robot_kit import simulated_robot
from window_kit import Operator

from gpr20_msgs.msg import ControlStatus
from gpr20_operator.ground.model import Layer
from gpr20_user_interface.window.rail import TabName
from pictures.kit import shown_window, wait

# A finished survey for the list, then the one that the pictures show.
SMALL_SURVEY = {"x_points": 3, "y_points": 3}
PART_SHOWN = 0.7
# Above the metallic sphere, between the depths of the two targets.
TARGET_MM = (155.0, 140.0, 60.0)


def make(folder: Path) -> None:
    """Take pictures of the plan, and of each tab during a survey."""
    with simulated_robot("time_scale:=50") as robot, shown_window(robot.data) as shown:
        window, operator = shown.window, Operator()
        known = window.survey
        wait(lambda: known.snapshot.can_start, "the robot is there")
        wait(lambda: known.snapshot.health.trouble is None, "each part reports")
        shown.take(folder, "plan")
        operator.start(**SMALL_SURVEY)
        wait(lambda: operator.code == ControlStatus.FINISHED, "a small survey ends")
        operator.start()
        wanted = round(PART_SHOWN * 21 * 21 * 2)
        wait(lambda: window.traces.live.radar.count >= wanted, "the survey shows both targets")
        window.ground.show_place(*TARGET_MM)

        def choose_survey() -> None:
            stored = window.traces.past
            wait(lambda: len(stored.surveys) == 2, "the list is there")
            window.past.choose(stored.surveys[1])

        for tab in TabName:
            window.show_tab(tab)
            if tab is TabName.SURVEYS:
                shown.take(folder, tab.value, choose_survey)
            else:
                shown.take(folder, tab.value)
        window.show_tab(TabName.GROUND)
        wait(lambda: window.ground.model.image is not None, "an image is focused")
        window.ground.model.switch(Layer.FOCUSED)
        shown.take(folder, "focused")
        operator.stop()
        wait(lambda: operator.code == ControlStatus.STOPPED, "the survey stops")
