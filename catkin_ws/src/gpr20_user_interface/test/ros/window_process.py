#!/usr/bin/env python3
"""The real program of the window, which says what it shows: one line of JSON per line it reads.

An empty line asks what an operator sees, another one where a part of the window is. Its options
are those of the program; without `_settings` it keeps nothing.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional

from PyQt5.QtCore import QPoint, QRect, QSocketNotifier
from PyQt5.QtGui import QGuiApplication
from PyQt5.QtWidgets import QApplication, QWidget

from gpr20_operator.ground.coverage import StopState
from gpr20_operator.high.control_client import plan_fields
from gpr20_operator.plan.fields import Tile
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import StartPlan
from gpr20_user_interface.high import user_interface
from gpr20_user_interface.widgets.bars import TabName

TAB = "tab:"
WINDOW = "window"


def shown(window: Any) -> Dict[str, Any]:
    """Return what an operator sees."""
    snapshot, bar, live = window.survey.snapshot, window.top_bar, window.traces.live
    progress, counts, state = snapshot.progress, live.map.counts(), snapshot.state
    return {
        "title": "—" if state is None else str(state.shown.label),
        "codes": [] if state is None else [one.code for one in state.message.faults],
        "survey_id": "" if state is None else state.survey_id,
        "condition": condition_of(snapshot).message.fault_code,
        "moving": [one.axis.value for one in snapshot.moving],
        "pending": len(snapshot.pending),
        "visited": 0 if progress is None else progress.visited_points,
        "area_traces": 0 if progress is None else progress.total_points,
        "trouble": snapshot.health.trouble is not None,
        "on_radar": live.radar.count,
        "on_map": 0 if counts is None else 2 * counts[StopState.DONE] + counts[StopState.PARTLY],
        "parameters": str(plan_fields(StartPlan(window.control.parameters))["parameters"]),
        "locked": not window.control.tiles[Tile.AREA].isEnabled(),
        "replay": bar.band.title.text() if snapshot.replay else "",
        "survey": bar.band.message.text(),
        "stop": bar.stop.isVisible() and bar.stop.isEnabled(),
        "alarm": bar.band.message.text() if bar.band.level is JobLevel.FAULT else "",
        "simulated": bar.band.simulated.isVisible(),
    }


def part(window: Any, name: str) -> Dict[str, Any]:
    """Return what is known of a part of the window.

    Args:
        window: The window.
        name: Attributes of the window separated by dots, such as `top_bar.stop`; `tab:MAP` a tab;
            `window` all of it.
    """
    if name == WINDOW:
        screen = QGuiApplication.primaryScreen().geometry()
        return {"screen": sides(screen), "window": sides(window.geometry())}
    if name.startswith(TAB):
        return described(window.rail.tabs[TabName[name[len(TAB) :]]])
    found: Optional[QWidget] = window
    for word in name.split("."):
        found = found[int(word)] if isinstance(found, list) else getattr(found, word)
    return described(found)


def described(widget: QWidget) -> Dict[str, Any]:
    """Return where a widget is, and how it is."""
    corner = widget.mapToGlobal(QPoint(0, 0))
    text = getattr(widget, "text", None)
    return {
        **dict(zip(("x", "y", "width", "height"), sides(QRect(corner, widget.size())))),
        "visible": widget.isVisible(),
        "enabled": widget.isEnabled(),
        "text": text() if callable(text) else "",
    }


def sides(rectangle: QRect) -> List[int]:
    """Return left, top, width and height."""
    return [rectangle.left(), rectangle.top(), rectangle.width(), rectangle.height()]


class AskedInterface(user_interface.UserInterface):
    """The window, which answers beside its work and ends when nobody asks any more."""

    def begin(self) -> None:
        super().begin()
        # Nothing else goes there: what ROS writes comes with the errors.
        self._answers = os.fdopen(os.dup(1), "w")
        os.dup2(2, 1)
        self._asked = QSocketNotifier(sys.stdin.fileno(), QSocketNotifier.Read)
        self._asked.activated.connect(lambda *_: self._answer())

    def _answer(self) -> None:
        line = sys.stdin.readline()
        if not line:
            self._asked.setEnabled(False)
            QApplication.quit()
            return
        name = line.strip()
        answer = part(self.window, name) if name else shown(self.window)
        print(json.dumps(answer), file=self._answers, flush=True)


class NoSettings:
    """In place of the files of a window."""

    def __init__(self, _path: Path) -> None:
        pass

    def read(self) -> Dict[str, Any]:
        return {}

    def write(self, _values: Mapping[str, Any]) -> None:
        pass


if __name__ == "__main__":
    if not any(word.startswith("_settings:=") for word in sys.argv):
        user_interface.SettingsFile = NoSettings
    user_interface.UserInterface = AskedInterface
    user_interface.main()
