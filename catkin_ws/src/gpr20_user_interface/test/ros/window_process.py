#!/usr/bin/env python3
"""A window in its own process that reports what it shows: one line of JSON per line it reads.

The line `stop` touches STOP first. With `--replay` the window shows a replay.
"""

from __future__ import annotations

import json
import sys

import rospy
from PyQt5.QtCore import QSocketNotifier, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from window_case import new_interface

from gpr20_common.catalogue import Language
from gpr20_common.low.clock import Clock
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.high.conversions import parameters_message
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.condition import JobLevel
from gpr20_operator.robot.replay_model import ReplayModel
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.look.translation import Languages


def shown(interface: UserInterface) -> str:
    """Return what an operator sees."""
    control, live = interface.window.control, interface.window.traces.live
    progress = interface.window.survey.snapshot.progress
    counts = live.map.counts()
    snapshot, bar = interface.window.survey.snapshot, interface.window.top_bar
    return json.dumps(
        {
            "title": "—" if snapshot.state is None else str(snapshot.state.title),
            "visited": 0 if progress is None else progress.visited_points,
            "area_traces": 0 if progress is None else progress.total_points,
            "nodes": len(snapshot.health.nodes),
            "on_radar": live.radar.count,
            "on_map": 0
            if counts is None
            else 2 * counts[StopState.DONE] + counts[StopState.PARTLY],
            "parameters": str(parameters_message(control.parameters)),
            "locked": not control.tiles[Tile.AREA].isEnabled(),
            "replay": bar.band.title.whole if snapshot.replay is not None else "",
            "survey": bar.band.message.whole,
            "stop": bar.stop.isVisible() and bar.stop.isEnabled(),
            "alarm": bar.band.message.whole if bar.band.level is JobLevel.FAULT else "",
            "simulated": interface.window.top_bar.band.simulated.isVisible(),
        }
    )


def main() -> None:
    """Show the window until the process is ended."""
    application = QApplication([])
    rospy.init_node("window", disable_signals=True)
    languages = Languages(application, Language.ENGLISH)
    replay = "--replay" in sys.argv
    interface = new_interface(ReplayModel() if replay else SurveyModel(Clock()), languages)
    interface.begin()

    def answer() -> None:
        line = sys.stdin.readline()
        if not line:
            application.quit()
            return
        if line.strip() == "stop":
            QTest.mouseClick(interface.window.top_bar.stop, Qt.LeftButton)
        print(shown(interface), flush=True)

    asked = QSocketNotifier(sys.stdin.fileno(), QSocketNotifier.Read)
    asked.activated.connect(lambda *_: answer())
    application.exec_()
    interface.end()
    rospy.signal_shutdown("nobody asks any more")


if __name__ == "__main__":
    main()
