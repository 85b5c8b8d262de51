"""Every tab and sheet of the window in each size, language and theme."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Callable, Dict

from robot_kit import simulated_robot
from window_kit import Operator

from gpr20_common.low import catalogue_file
from gpr20_common.message import verbatim
from gpr20_msgs.msg import ControlStatus
from gpr20_operator.palette import Theme
from gpr20_operator.plan.fields import VALUE_TILES
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.window.main_window import MainWindow, TabName
from pictures.kit import Shown, save, shown_window, wait

SIZES = ((480, 320), (800, 480), (1280, 800))
LARGEST = "1280x800x24"
SURVEY = {"x_points": 13, "y_points": 13}
DRAWN_S = 0.3
REASON = "the VNA does not answer; check its network cable and its power, then resume"


def make(folder: Path) -> None:
    """Take the pictures of a robot at rest, and of one whose survey is paused."""
    with simulated_robot("time_scale:=50") as robot, shown_window(robot.data, LARGEST) as shown:
        window, operator = shown.window, Operator()
        wait(window.control.start.isEnabled, "START is unlocked")
        take(shown, folder, "idle", {**tabs(window), **sheets(window)})
        operator.start(**SURVEY)
        wait(lambda: window.traces.live.radar.count >= 200, "the survey shows a target")
        operator.pause()
        wait(lambda: operator.code == ControlStatus.PAUSED, "it pauses")
        take(shown, folder, "paused", tabs(window))
        operator.stop()
        wait(lambda: operator.code == ControlStatus.STOPPED, "the survey stops")


def take(shown: Shown, folder: Path, prefix: str, openers: Dict[str, Callable[[], None]]) -> None:
    """Take a picture after each opener, in each size, language and theme."""
    window = shown.window
    for size in SIZES:
        window.resize(*size)
        for language in catalogue_file.languages():
            shown.languages.use(language)
            for theme in Theme:
                window.use_look(replace(window.look, theme=theme))
                kind = f"{size[0]}x{size[1]}_{language.value}_{theme.value}"
                for name, open_it in openers.items():
                    close_sheets(window)
                    open_it()
                    save(window, folder / kind / f"{prefix}_{name}.png", DRAWN_S)


def close_sheets(window: MainWindow) -> None:
    """Close what is open over the tabs."""
    for sheet in window.findChildren(Overlay):
        if isinstance(sheet, Overlay):
            sheet.hide()


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
        "check_plan": window.control.check_plan.click,
        "profiles": window.control.saved.click,
        "start": window.control.start.click,
        "settings": window.rail.settings.click,
        "refused": lambda: window.notice.show_notice(
            refusal_notice(Refused.RESUME, verbatim(REASON))
        ),
    }
