"""What the pictures of windows share: a window on a screen of its own, waiting, and saving."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Callable, Iterator

import rosgraph
import rospy
from PyQt5.QtWidgets import QApplication, QWidget
from window_kit import SCREEN, new_window, run_events, run_until, virtual_screen

from gpr20_common import catalogue
from gpr20_common.catalogue import Language
from gpr20_user_interface.look.translation import Languages

LIMIT_S = 300.0
DRAWN_S = 1.0


def wait(condition: Callable[[], bool], what: str) -> None:
    """Let the window live until a condition holds."""
    run_until(condition, what, LIMIT_S)


def save(widget: QWidget, path: Path, drawn_s: float = DRAWN_S) -> None:
    """Write what a window shows after it was given time to draw [s]."""
    run_events(drawn_s)
    path.parent.mkdir(parents=True, exist_ok=True)
    if not widget.grab().save(str(path)):
        raise SystemExit(f"{path} cannot be written")
    print(path, flush=True)


class Shown:
    """The window of the robot while it is shown.

    Args:
        languages: Its languages.
        data: Folder of what it remembers.
        replay: Whether it shows a replay.

    Attributes:
        window: It.
        languages: Its languages.
    """

    def __init__(self, languages: Languages, data: Path, replay: bool) -> None:
        self._interface = new_window(languages, data, replay)
        self._interface.begin()
        self.window = self._interface.window
        self.languages = languages

    def take(self, folder: Path, name: str, prepare: Callable[[], None] = lambda: None) -> None:
        """Take a picture in each language.

        Args:
            folder: Where it is written.
            name: The name of its file, without the language.
            prepare: Called in each language before the picture.
        """
        for language in catalogue.languages():
            self.languages.use(language)
            prepare()
            save(self.window, folder / f"{name}_{language.value}.png")

    def end(self) -> None:
        """End its work."""
        self._interface.end()
        self.languages.close()


@contextlib.contextmanager
def shown_window(data: Path, screen: str = SCREEN, replay: bool = False) -> Iterator[Shown]:
    """Show the window of the robot whose master is known, on a screen of its own.

    Args:
        data: Folder of what it remembers.
        screen: Width, height and depth of the screen [pixels, bits].
        replay: Whether it shows a replay.
    """
    with virtual_screen(screen):
        application = QApplication([])
        wait(rosgraph.is_master_online, "the master is there")
        rospy.init_node("pictures", disable_signals=True)
        shown = Shown(Languages(application, Language.ENGLISH), data, replay)
        try:
            yield shown
        finally:
            shown.end()
            rospy.signal_shutdown("the pictures are taken")
