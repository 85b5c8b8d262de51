"""Pictures of every tab of the window during a survey; started by screenshots.sh."""

from __future__ import annotations

import sys
from pathlib import Path

import rospy
from PyQt5.QtWidgets import QApplication, QWidget
from robot_kit import simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_common.low import catalogue_file
from gpr20_msgs.msg import ControlStatus
from gpr20_user_interface.mid.map_grid import Stop
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.translation import Languages

# A finished survey for the list, then the one that the pictures show.
SMALL_SURVEY = {"x_points": 3, "y_points": 3}
PART_SHOWN = 0.7
LIMIT_S = 300.0
TARGET_STOP = Stop(6, 7)  # above the metallic sphere
SLICE_STEPS = 12  # 60 mm, between the depths of the two targets


def keep(window: QWidget, path: Path) -> None:
    """Write what the window shows."""
    run_events(1.0)
    if not window.grab().save(str(path)):
        raise SystemExit(f"{path} cannot be written")
    print(path)


def take_pictures(folder: Path, data: Path, application: QApplication) -> None:
    """Take pictures of the plan, and of each tab during a survey, in each language."""
    languages = Languages(application, Language.ENGLISH)
    interface = new_window(languages, data)
    interface.begin()
    window = interface.window
    run_until(lambda: window.survey.snapshot.can_start, "the robot is ready", LIMIT_S)
    for language in catalogue_file.languages():
        languages.use(language)
        keep(window, folder / f"plan_{language.value}.png")
    operator = Operator()
    operator.start(**SMALL_SURVEY)
    run_until(lambda: operator.code == ControlStatus.FINISHED, "a small survey ends", LIMIT_S)
    operator.start()
    live = interface.window.traces.live
    wanted = round(PART_SHOWN * 21 * 21 * 2)
    run_until(lambda: live.radar.count >= wanted, "the survey shows both targets", LIMIT_S)
    window.map.select_stop(TARGET_STOP)
    window.radar.depth_slider.setValue(SLICE_STEPS)
    for language in catalogue_file.languages():
        languages.use(language)
        for tab in TabName:
            window.show_tab(tab)
            if tab is TabName.SURVEYS:
                run_until(lambda: window.past.table.rowCount() == 2, "the list is there", LIMIT_S)
                window.past.table.selectRow(1)
            keep(window, folder / f"{tab.value}_{language.value}.png")
    window.show_tab(TabName.RADAR)
    window.radar.source.click()
    run_until(lambda: window.radar.presenter.image is not None, "an image is focused", LIMIT_S)
    for language in catalogue_file.languages():
        languages.use(language)
        keep(window, folder / f"focused_{language.value}.png")
    operator.stop()
    run_until(lambda: operator.code == ControlStatus.STOPPED, "the survey stops", LIMIT_S)
    interface.end()
    languages.close()


def main() -> None:
    """Take the pictures into the folder that is named."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with virtual_screen(), simulated_robot("time_scale:=50") as robot:
        application = QApplication([])
        rospy.init_node("screenshots", disable_signals=True)
        take_pictures(folder, robot.data, application)
        rospy.signal_shutdown("the pictures are taken")


if __name__ == "__main__":
    main()
