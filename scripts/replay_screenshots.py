"""Pictures of the window during the replay of a survey; started by screenshots.sh."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import rosgraph
import rospy
from PyQt5.QtWidgets import QApplication
from robot_kit import free_port, running
from window_kit import new_window, run_events, run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_common.low import catalogue_file
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.translation import Languages

LIMIT_S = 120.0
# Traces that are shown before the pictures.
SHOWN = 20


def take_pictures(folder: Path, survey: Path, application: QApplication) -> None:
    """Replay the survey and take a picture in each language."""
    languages = Languages(application, Language.ENGLISH)
    interface = new_window(languages, folder)
    interface.begin()
    window = interface.window
    with running("rosrun", "gpr20_analysis", "replay", str(survey)):
        run_until(lambda: window.traces.live.radar.count >= SHOWN, "traces are shown", LIMIT_S)
        for language in catalogue_file.languages():
            languages.use(language)
            window.show_tab(TabName.STATUS)
            run_events(1.0)
            path = folder / f"replay_{language.value}.png"
            if not window.grab().save(str(path)):
                raise SystemExit(f"{path} cannot be written")
            print(path)
    interface.end()
    languages.close()


def main() -> None:
    """Take the pictures of the survey that is named into the folder that is named."""
    survey, folder = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    port = free_port()
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    with virtual_screen(), running("roscore", "-p", str(port)):
        deadline_s = time.monotonic() + LIMIT_S
        while not rosgraph.is_master_online():
            if time.monotonic() > deadline_s:
                raise SystemExit("the master does not start")
            time.sleep(0.1)
        application = QApplication([])
        rospy.init_node("replay_screenshots", disable_signals=True)
        take_pictures(folder, survey, application)
        rospy.signal_shutdown("the pictures are taken")


if __name__ == "__main__":
    main()
