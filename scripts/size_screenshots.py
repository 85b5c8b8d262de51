"""Pictures of every tab and sheet in each size, language and theme; started by screenshots.sh."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Callable, Dict

import rospy
from PyQt5.QtWidgets import QApplication
from robot_kit import simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_common.low import catalogue_file
from gpr20_common.message import verbatim
from gpr20_msgs.msg import ControlStatus
from gpr20_user_interface.mid.notices import Refused, refusal_notice
from gpr20_user_interface.mid.plan_tiles import VALUE_TILES
from gpr20_user_interface.mid.window_settings import Theme
from gpr20_user_interface.views.main_window import MainWindow, TabName
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.translation import Languages

SIZES = ((480, 320), (800, 480), (1280, 800))
LARGEST = "1280x800x24"
SURVEY = {"x_points": 13, "y_points": 13}
LIMIT_S = 300.0
DRAWN_S = 0.3
REASON = "the VNA does not answer; check its network cable and its power, then resume"


class Pictures:
    """Takes the pictures of a window.

    Args:
        window: The window.
        languages: Its languages.
        folder: Where the pictures are written.
    """

    def __init__(self, window: MainWindow, languages: Languages, folder: Path) -> None:
        self._window = window
        self._languages = languages
        self._folder = folder

    def take(self, prefix: str, openers: Dict[str, Callable[[], None]]) -> None:
        """Take a picture after each opener, in each size, language and theme."""
        for size in SIZES:
            self._window.resize(*size)
            for language in catalogue_file.languages():
                self._languages.use(language)
                for theme in Theme:
                    self._window.use_look(replace(self._window.look, theme=theme))
                    for name, open_it in openers.items():
                        self._close_sheets()
                        open_it()
                        run_events(DRAWN_S)
                        kind = f"{size[0]}x{size[1]}_{language.value}_{theme.value}"
                        self._write(self._folder / kind / f"{prefix}_{name}.png")

    def _close_sheets(self) -> None:
        for sheet in self._window.findChildren(Overlay):
            if isinstance(sheet, Overlay):
                sheet.hide()

    def _write(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not self._window.grab().save(str(path)):
            raise SystemExit(f"{path} cannot be written")


def tabs(window: MainWindow) -> Dict[str, Callable[[], None]]:
    """Return what shows each tab."""
    return {tab.value: partial(window.show_tab, tab) for tab in TabName}


def sheets(window: MainWindow) -> Dict[str, Callable[[], None]]:
    """Return what opens each sheet of a robot at rest."""
    openers: Dict[str, Callable[[], None]] = {
        f"tile_{tile.value}": partial(window.values.show_tile, tile) for tile in VALUE_TILES
    }
    return {
        **openers,
        "figures": window.control.figures.click,
        "profiles": window.control.profiles.click,
        "start": window.control.start.click,
        "settings": window.settings.button.click,
        "refused": lambda: window.notice.show_notice(
            refusal_notice(Refused.RESUME, verbatim(REASON))
        ),
    }


def main() -> None:
    """Take the pictures into the folder that is named."""
    folder = Path(sys.argv[1])
    with virtual_screen(LARGEST), simulated_robot("time_scale:=50") as robot:
        application = QApplication([])
        rospy.init_node("screenshots", disable_signals=True)
        languages = Languages(application, Language.ENGLISH)
        interface = new_window(languages, robot.data)
        interface.begin()
        window, operator = interface.window, Operator()
        pictures = Pictures(window, languages, folder)
        run_until(lambda: window.control.start.isEnabled(), "START is unlocked", LIMIT_S)
        pictures.take("idle", {**tabs(window), **sheets(window)})
        operator.start(**SURVEY)
        live = window.traces.live
        run_until(lambda: live.radar.count >= 200, "the survey shows a target", LIMIT_S)
        operator.pause()
        run_until(lambda: operator.code == ControlStatus.PAUSED, "it pauses", LIMIT_S)
        pictures.take("paused", tabs(window))
        operator.stop()
        run_until(lambda: operator.code == ControlStatus.STOPPED, "the survey stops", LIMIT_S)
        interface.end()
        languages.close()
        rospy.signal_shutdown("the pictures are taken")
    print(f"pictures in {folder}")


if __name__ == "__main__":
    main()
