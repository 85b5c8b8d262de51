#!/usr/bin/env python3
"""A window in its own process that says where on the screen its parts are, for real touches.

It reads names of widgets, one per line, and answers each with a line of JSON.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, Dict, List, Optional

import rospy
from PyQt5.QtCore import QPoint, QRect, QSocketNotifier
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QAbstractButton, QApplication, QLabel, QLineEdit, QWidget

from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import language_from_code
from gpr20_common.low.clock import Clock
from gpr20_operator.files.settings_file import SettingsFile
from gpr20_operator.plan.profiles import Profiles
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.look.settings import WindowMemory
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.window.rail import TabName

TEXT = "text:"
TAB = "tab:"
WINDOW = "window"
KEYS = "keys"
PICTURE = "picture:"


class Describer:
    """Answers questions about a window."""

    def __init__(self, window: Any) -> None:
        self._window = window

    def answer(self, name: str) -> Dict[str, Any]:
        """Return what is known of a part of the window.

        Args:
            name: Attributes of the window separated by dots, such as `top_bar.stop`; keys of
                dictionaries by their name or text; `text:STOP` a visible button with that text;
                `tab:MAP` a tab; `window` all of it; `keys` the places of all keys that are seen;
                `picture:FILE` writes a picture.
        """
        if name == WINDOW:
            return self._whole()
        if name == KEYS:
            return {"keys": self._keys()}
        if name.startswith(PICTURE):
            return {"written": self._window.grab().save(name[len(PICTURE) :])}
        if name.startswith(TAB):
            return _described(self._window.rail.tabs[TabName[name[len(TAB) :]]])
        widget = self._with_text(name[len(TEXT) :]) if name.startswith(TEXT) else self._at(name)
        return {"visible": False} if widget is None else _described(widget)

    def _whole(self) -> Dict[str, Any]:
        window = self._window
        screen = QGuiApplication.primaryScreen().geometry()
        kinds = (QAbstractButton, QLabel, QLineEdit)
        parts = [one for kind in kinds for one in window.findChildren(kind) if one.isVisible()]
        outside: List[str] = []
        for part in parts:
            shown = part.visibleRegion().boundingRect()
            place = QRect(part.mapToGlobal(shown.topLeft()), shown.size())
            if not shown.isEmpty() and not screen.contains(place):
                outside.append(part.objectName() or part.text())
        return {
            "screen": _sides(screen),
            "window": _sides(window.geometry()),
            "frame": _sides(window.frameGeometry()),
            "outside": outside,
            "scale": window.look.scale,
        }

    def _keys(self) -> List[List[int]]:
        found = []
        for key in self._window.findChildren(QAbstractButton):
            seen = key.visibleRegion().boundingRect()
            if key.isVisible() and key.isEnabled() and not seen.isEmpty():
                centre = key.mapToGlobal(seen.center())
                found.append([centre.x(), centre.y()])
        return found

    def _with_text(self, text: str) -> Optional[QWidget]:
        for button in self._window.findChildren(QAbstractButton):
            shown = " ".join(button.text().replace("&", "").split())
            if button.isVisible() and shown == text:
                return button
        return None

    def _at(self, name: str) -> Optional[QWidget]:
        found: Any = self._window
        for part in name.split("."):
            if isinstance(found, list):
                found = found[int(part)]
            elif isinstance(found, dict):
                keys = {getattr(key, "name", str(key)): key for key in found}
                found = found[keys[part]]
            else:
                found = getattr(found, part)
        return found


def _described(widget: QWidget) -> Dict[str, Any]:
    corner = widget.mapToGlobal(QPoint(0, 0))
    text = getattr(widget, "text", None)
    return {
        **dict(zip(("x", "y", "width", "height"), _sides(QRect(corner, widget.size())))),
        "visible": widget.isVisible(),
        "enabled": widget.isEnabled(),
        "text": text() if callable(text) else "",
    }


def _sides(rectangle: QRect) -> List[int]:
    return [rectangle.left(), rectangle.top(), rectangle.width(), rectangle.height()]


def main() -> None:
    """Show the window until nobody asks any more."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path, required=True, help="of settings and profiles")
    parser.add_argument("--full-screen", action="store_true")
    parser.add_argument("--language", type=language_from_code, default=Language.ENGLISH)
    given = parser.parse_args(rospy.myargv()[1:])
    application = QApplication([])
    rospy.init_node("window", disable_signals=True)
    memory = WindowMemory(SettingsFile(given.folder / "window.yaml"))
    languages = Languages(application, given.language)
    profiles = Profiles(given.folder / "profiles")
    plan = SettingsFile(given.folder / "plan.yaml")
    interface = UserInterface(
        SurveyModel(Clock()), languages, profiles, plan, memory, given.full_screen
    )
    interface.begin()
    describer = Describer(interface.window)

    def answer() -> None:
        line = sys.stdin.readline()
        if not line:
            application.quit()
            return
        print(json.dumps(describer.answer(line.strip())), flush=True)

    asked = QSocketNotifier(sys.stdin.fileno(), QSocketNotifier.Read)
    asked.activated.connect(lambda *_: answer())
    application.exec_()
    interface.end()
    memory.close(10.0)
    rospy.signal_shutdown("nobody asks any more")


if __name__ == "__main__":
    main()
