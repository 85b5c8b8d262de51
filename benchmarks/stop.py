"""STOP of the window or of the page: from the finger to the last pulse of any axis.

    scripts/bench.sh stop --stops 100
    scripts/bench.sh stop --stops 100 --page 20     (of the page, while 20 others watch it)

The whole simulated robot at `time_scale` 1 moves x, y and z through their full travel, as a person
at a terminal would, while the window shows one tab after the other. `xdotool` presses STOP at a
random moment of each move. The time counts from before `xdotool` begins until the last pulse of
the axis that stops last, so it contains the start of that program, X server and window; at top
speed the ramp alone takes 231 ms (docs/evidence/motion.md).

With `--page`, a client over TLS takes the place of window and `xdotool`: each press has a
connection of its own, and the time counts from before that is opened. Those who watch read the
live document in another process, each with a session of its own.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Callable, Dict, List

import actionlib
import numpy as np
import rospy
from page_kit import Client, new_page, watchers
from PyQt5.QtCore import QCoreApplication
from PyQt5.QtWidgets import QApplication
from robot_kit import simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_msgs.msg import AxisAction, AxisGoal, CurrentCoordinate
from gpr20_msgs.srv import Command
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes import AxisId
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.widgets.bars import TabName

LIMIT_S = 60.0
# An axis that has made no step for so long has stopped.
REST_S = 0.5
# The ends of the moves [mm, mm, deg], and from when to when STOP is pressed.
ENDS = {AxisId.X: (20.0, 640.0), AxisId.Y: (20.0, 640.0), AxisId.Z: (0.0, 90.0)}
FROM_S, TO_S = 0.2, 1.5


class Axes:
    """The simulated axes, moved past the main control.

    Attributes:
        reports: What each axis reported last.
    """

    def __init__(self) -> None:
        self.reports: Dict[AxisId, CurrentCoordinate] = {}
        self._clients, self._subscribers = {}, []
        for axis in AxisId:
            self._clients[axis] = actionlib.SimpleActionClient(
                f"{axis.value}_axis/axis", AxisAction
            )
            self._clients[axis].wait_for_server(rospy.Duration(LIMIT_S))
            note = partial(self.reports.__setitem__, axis)
            name = f"{axis.value}_axis/current_coord"
            self._subscribers.append(rospy.Subscriber(name, CurrentCoordinate, note))
        run_until(lambda: len(self.reports) == len(AxisId), "every axis reports", LIMIT_S)
        # The first process of the robot makes it.
        self._world = open_shared_state(shared_state_path("/"))

    def begin_moves(self, operator: Operator) -> None:
        """Send every axis to its farther end; one that has lost its zero finds it first."""
        for axis, (near, far) in ENDS.items():
            if not self.reports[axis].homed:
                operator.call(f"{axis.value}_axis/homing", Command)
            target = far if self.reports[axis].coordinate < (near + far) / 2 else near
            self._clients[axis].send_goal(AxisGoal(target_coordinate=target))
        run_until(lambda: self.reports[AxisId.X].moving, "x moves", LIMIT_S)

    def wait_for_rest(self) -> int:
        """Return when the last pulse was, once no axis has made one for a while [ns]."""
        last_ns = time.monotonic_ns()
        while time.monotonic_ns() - last_ns < REST_S * 1e9:
            run_events(0.05)
            last_ns = max(self._world.last_pulse_ns(axis) for axis in AxisId)
        return last_ns


def press_key(interface: UserInterface) -> int:
    """Press STOP with a finger; return when that began [ns of time.monotonic_ns()]."""
    key = interface.window.top_bar.stop
    at = key.mapToGlobal(key.rect().center())
    subprocess.run(["xdotool", "mousemove", str(at.x()), str(at.y())], check=True)
    run_events(0.1)
    begin_ns = time.monotonic_ns()
    finger = subprocess.Popen(["xdotool", "mousedown", "1", "sleep", "0.3", "mouseup", "1"])
    run_until(lambda: finger.poll() is not None, "the finger leaves", LIMIT_S)
    return begin_ns


def press_button(client: Client) -> int:
    """Press STOP of the page; return when that began [ns of time.monotonic_ns()]."""
    begin_ns = time.monotonic_ns()
    client.press("stop")
    return begin_ns


def measure(press: Callable[[int], int], stops: int, seed: int) -> List[float]:
    operator, drawn, found_ms = Operator(), random.Random(seed), []
    axes = Axes()
    for number in range(stops):
        axes.begin_moves(operator)
        run_events(drawn.uniform(FROM_S, TO_S))
        begin_ns = press(number)
        found_ms.append((axes.wait_for_rest() - begin_ns) / 1e6)
        print(f"stop {number}: {found_ms[-1]:.1f} ms", flush=True)
        x_mm = axes.reports[AxisId.X].coordinate
        if x_mm in ENDS[AxisId.X]:
            raise SystemExit(f"stop {number}: x has reached the end of its move, {x_mm:g} mm")
    return found_ms


def of_window(stops: int, seed: int) -> List[float]:
    tabs = list(TabName)
    with virtual_screen(), simulated_robot("time_scale:=1") as robot:
        application = QApplication(sys.argv[:1])
        rospy.init_node("stop_benchmark", disable_signals=True)
        interface = new_window(Languages(application, Language.ENGLISH), robot.data)
        interface.begin()
        interface.window.showFullScreen()

        def press(number: int) -> int:
            begin_ns = press_key(interface)
            interface.window.show_tab(tabs[number % len(tabs)])
            return begin_ns

        found_ms = measure(press, stops, seed)
        interface.end()
        rospy.signal_shutdown("measured")
    return found_ms


def of_page(stops: int, seed: int, count: int) -> List[float]:
    with tempfile.TemporaryDirectory(prefix="gpr20_stop_") as folder:
        page = new_page(Path(folder))
        with simulated_robot("time_scale:=1", *page.options):
            # It carries the events of the moves.
            _application = QCoreApplication(sys.argv[:1])
            rospy.init_node("stop_benchmark", disable_signals=True)
            client = Client(page.port)
            with watchers(page, count):
                found_ms = measure(lambda _number: press_button(client), stops, seed)
            rospy.signal_shutdown("measured")
    return found_ms


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--stops", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--page", type=int, metavar="WATCHERS", help="of the page, not the window")
    chosen = parser.parse_args()
    if chosen.page is None:
        found_ms = of_window(chosen.stops, chosen.seed)
    else:
        found_ms = of_page(chosen.stops, chosen.seed, chosen.page)
    low, median, high, highest = np.percentile(found_ms, [0.0, 50.0, 90.0, 99.0])
    print(
        f"{len(found_ms)} stops, from the finger to the last pulse: at least {low:.0f} ms, median "
        f"{median:.0f} ms, 90th percentile {high:.0f} ms, 99th {highest:.0f} ms, at most "
        f"{max(found_ms):.0f} ms"
    )


if __name__ == "__main__":
    main()
