"""Every tab of the window during a survey."""

from __future__ import annotations

from pathlib import Path

from robot_kit import simulated_robot
from window_kit import Operator

from gpr20_msgs.msg import ControlStatus
from gpr20_operator.ground.grid import Stop
from gpr20_user_interface.window.rail import TabName
from pictures.kit import shown_window, wait

# A finished survey for the list, then the one that the pictures show.
SMALL_SURVEY = {"x_points": 3, "y_points": 3}
PART_SHOWN = 0.7
TARGET_STOP = Stop(6, 7)  # above the metallic sphere
SLICE_STEPS = 12  # 60 mm, between the depths of the two targets


def make(folder: Path) -> None:
    """Take pictures of the plan, and of each tab during a survey."""
    with simulated_robot("time_scale:=50") as robot, shown_window(robot.data) as shown:
        window, operator = shown.window, Operator()
        wait(lambda: window.survey.snapshot.can_start, "the robot is ready")
        shown.take(folder, "plan")
        operator.start(**SMALL_SURVEY)
        wait(lambda: operator.code == ControlStatus.FINISHED, "a small survey ends")
        operator.start()
        wanted = round(PART_SHOWN * 21 * 21 * 2)
        wait(lambda: window.traces.live.radar.count >= wanted, "the survey shows both targets")
        window.map.select_stop(TARGET_STOP)
        window.radar.depth_slider.setValue(SLICE_STEPS)

        def choose_survey() -> None:
            wait(lambda: window.past.table.rowCount() == 2, "the list is there")
            window.past.table.selectRow(1)

        for tab in TabName:
            window.show_tab(tab)
            if tab is TabName.SURVEYS:
                shown.take(folder, tab.value, choose_survey)
            else:
                shown.take(folder, tab.value)
        window.show_tab(TabName.RADAR)
        window.radar.source.click()
        wait(lambda: window.radar.presenter.image is not None, "an image is focused")
        shown.take(folder, "focused")
        operator.stop()
        wait(lambda: operator.code == ControlStatus.STOPPED, "the survey stops")
