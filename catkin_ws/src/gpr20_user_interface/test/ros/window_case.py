"""What tests with a real window on a real screen have in common."""

from __future__ import annotations

import os
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional, Type, Union

import rospy
import rostest
import waiting
from PyQt5 import sip
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QWidget
from virtual_screen import VirtualScreen

from gpr20_common.catalogue import Language
from gpr20_common.low.clock import Clock
from gpr20_operator.plan.fields import TILE_FIELDS, VALUE_TILES
from gpr20_operator.plan.profiles import Profiles
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.replay_model import ReplayModel
from gpr20_operator.robot.survey_model import Refusal, SurveyModel
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.widgets.hold_sheet import HoldSheet


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """Return when the condition holds, the window's events being handled meanwhile."""
    waiting.wait_until(condition, what, pause=lambda: QTest.qWait(20))


def new_interface(model: Union[SurveyModel, ReplayModel], languages: Languages) -> UserInterface:
    """Return a window that is connected to the graph; it remembers nothing of another one."""
    folder = Path(tempfile.gettempdir()) / "gpr20_no_profiles"
    return UserInterface(model, languages, Profiles(folder), NoSettings())


class NoSettings:
    """Settings that are not kept."""

    def read(self) -> Dict[str, Any]:
        return {}

    def write(self, values: Mapping[str, Any]) -> None:
        pass


class WatchedModel(SurveyModel):
    """Remembers which threads called it."""

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock)
        self.threads: set = set()

    def handle(self, event: object) -> Optional[Refusal]:
        self.threads.add(threading.current_thread())
        return super().handle(event)


class WindowCase(unittest.TestCase):
    """Opens a window and does with it what a finger does."""

    def open_window(self) -> None:
        self.model = WatchedModel(Clock())
        self.languages = Languages(QApplication.instance(), Language.ENGLISH)
        self.addCleanup(self.languages.close)
        self.interface = new_interface(self.model, self.languages)
        self.window = self.interface.window
        self.interface.begin()
        self.addCleanup(self.end_interface)

    def end_interface(self) -> None:
        # Widgets that other threads touch crash after tens of minutes.
        self.assertLessEqual(self.model.threads, {threading.main_thread()})
        self.interface.end()
        sip.delete(self.window)

    def title(self) -> str:
        """Return the last state of the main control; "—": there was none."""
        state = self.window.survey.snapshot.state
        return "—" if state is None else str(state.title)

    def enter(self, name: str, text: str) -> None:
        self.open_field(name)
        QTest.keyClicks(self.window.values, text)
        self.close_sheet()

    def open_field(self, name: str) -> None:
        """Open the sheet of the tile on which a field is, and choose the field."""
        tile = next(one for one in VALUE_TILES if name in TILE_FIELDS[one])
        wait_until(lambda: self.opened(tile), "the sheet opens")
        self.window.values.choose(name)

    def opened(self, tile: Tile) -> bool:
        # No touch is taken for a moment after something has closed.
        if self.window.result.plan.isVisible():
            self.touch(self.window.result.plan)
        elif not self.window.values.isVisible():
            self.touch(self.window.control.tiles[tile])
        return self.window.values.isVisible()

    def close_sheet(self) -> None:
        def closed() -> bool:
            if self.window.values.isVisible():
                self.touch(self.window.values.done)
            return not self.window.values.isVisible()

        wait_until(closed, "the sheet closes")

    def touch_notes(self) -> None:
        """Open the notes: of the next survey on CONTROL, of a running one on its job screen."""
        job = self.window.job
        self.touch(job.notes if job.notes.isVisible() else self.window.control.tiles[Tile.NAME])

    def touch(self, widget: QWidget) -> None:
        QTest.mouseClick(widget, Qt.LeftButton)

    def hold(self, sheet: Optional[HoldSheet] = None) -> None:
        """Hold the button of a sheet; None: of that before the robot moves."""
        button = (sheet or self.window.start_sheet).hold
        QTest.mousePress(button, Qt.LeftButton)
        wait_until(lambda: not button.isVisible(), "it was held")
        QTest.mouseRelease(button, Qt.LeftButton)

    def click(self, name: str) -> None:
        if name == "start" and self.window.result.plan.isVisible():
            self.touch(self.window.result.plan)
        self.touch(self.buttons()[name])
        if self.window.start_sheet.isVisible():
            self.hold()

    def buttons(self) -> Dict[str, Any]:
        bar = self.window.top_bar
        held = "resume" if bar.pause.text() == "RESUME" else "pause"
        return {"start": self.window.control.start, "stop": bar.stop, held: bar.pause}

    def enabled(self) -> str:
        """Return the buttons that can be pressed beside STOP, which always can."""
        buttons = self.buttons()
        self.assertTrue(buttons.pop("stop").isEnabled())
        return " ".join(name for name, button in buttons.items() if button.isEnabled())

    def keep_picture(self, name: str) -> None:
        """Write what is on the screen where an engineer can look at it."""
        folder = os.environ.get("GPR20_PICTURES", "")
        if not folder:
            folder = tempfile.mkdtemp()
            self.addCleanup(lambda: os.rmdir(folder))
            self.addCleanup(lambda: os.remove(path))
        path = os.path.join(folder, f"{name}.png")
        picture = self.window.grab()
        self.assertTrue(picture.save(path))
        self.assertEqual((picture.width(), picture.height()), (800, 480))


def run_on_a_screen(name: str, case: Type[unittest.TestCase]) -> None:
    """Run the tests of a class on a screen of their own."""
    screen = VirtualScreen()
    os.environ["DISPLAY"] = screen.name
    os.environ["QT_QPA_PLATFORM"] = "xcb"
    application = QApplication([])
    rospy.init_node(f"test_{name}", disable_signals=True)
    try:
        rostest.rosrun("gpr20_user_interface", name, case)
    finally:
        rospy.signal_shutdown("the tests are over")
        # Qt lets go of the screen before the screen goes away.
        sip.delete(application)
        screen.close()
