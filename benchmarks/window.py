"""The real window on the whole simulated robot: memory, processor time, how fluent it is.

Surveys of the simulated robot follow each other at full speed while the window shows one tab
after the other, and each axis publishes at 50 Hz while it moves. Everything of the window runs in
this process, so its own counters are those of the window.

    scripts/bench.sh window --minutes 120                              (memory over two hours)
    scripts/bench.sh window --tab ground --time-scale 150 --minutes 5   (one tab)

A heartbeat of 10 ms measures how long the window's thread was busy with something else: beyond
50 ms it could not have drawn 20 frames a second. While GROUND is shown, the time from the arrival
of a trace to its first drawing from above is measured. `--rest` starts no survey. `--plain` leaves
the heartbeat and these delays out, so that the processor time is the window's own. OpenBLAS gets
one thread, as in the launch files: its idle threads would be counted as the window's.
"""

from __future__ import annotations

import argparse
import gc
import os
import resource
import statistics
import sys
import time
from typing import Dict, List

import numpy as np
import rospy
from PyQt5.QtCore import QEvent, QObject, Qt, QTimer
from PyQt5.QtWidgets import QApplication, QWidget
from robot_kit import resident_mib, simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_common.high.raw_message import deserialized
from gpr20_msgs.msg import ControlStatus, Trace
from gpr20_operator.palette import NOT_MEASURED
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.widgets.bars import TabName

HEARTBEAT_MS = 10
FRAME_S = 0.05
TAB_S = 5.0
START_LIMIT_S = 120.0
# Memory before this is that of libraries and caches being filled.
WARM_UP_MINUTES = 2
ENDED = (
    ControlStatus.IDLE,
    ControlStatus.CONFIGURED,
    ControlStatus.FINISHED,
    ControlStatus.STOPPED,
    ControlStatus.FAILED,
)


class Heartbeat:
    """Notes how long the window's thread was away."""

    def __init__(self) -> None:
        self.gaps_s: List[float] = []
        self._last_s = time.monotonic()
        self._timer = QTimer()

    def start(self) -> None:
        """Note from now on."""
        self._last_s = time.monotonic()
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._beat)
        self._timer.start(HEARTBEAT_MS)

    def _beat(self) -> None:
        now_s = time.monotonic()
        self.gaps_s.append(now_s - self._last_s)
        self._last_s = now_s


class Delays(QObject):
    """Notes when a trace arrives and when GROUND is first painted with it."""

    def __init__(self, interface: UserInterface, plain: bool) -> None:
        super().__init__()
        self.delays_s: List[float] = []
        self.traces = 0
        self._ground = interface.window.ground
        self._above = self._ground.view.above
        self._arrived_s: Dict[int, float] = {}
        # As the window receives them: the subscriptions of one process are of one type.
        note = self._count if plain else self._note
        self._subscriber = rospy.Subscriber("trace", rospy.AnyMsg, note)
        if not plain:
            self._above.viewport().installEventFilter(self)

    def _count(self, _message: rospy.AnyMsg) -> None:
        self.traces += 1

    def _note(self, message: rospy.AnyMsg) -> None:
        self._arrived_s[deserialized(Trace, message._buff).index] = time.monotonic()
        self.traces += 1

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the view from above."""
        if event.type() == QEvent.Type.Paint:
            # Painted after this.
            QTimer.singleShot(0, self._look)
        return False

    def _look(self) -> None:
        numbers, grid = self._above.numbers, self._ground.model.survey.radar.grid
        if numbers is None or grid is None:
            return
        now_s, drawn = time.monotonic(), numbers != NOT_MEASURED
        for index in list(self._arrived_s):
            row, column, polarization = grid.cells(np.array(index))
            if polarization != self._ground.model.settings.polarization:
                del self._arrived_s[index]
            elif drawn[row, column]:
                self.delays_s.append(now_s - self._arrived_s.pop(index))


def processor_s() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def frames_per_s(window: QWidget) -> float:
    """Return how often the whole window can be drawn in a second."""
    count = 20
    begin_s = time.perf_counter()
    for _ in range(count):
        window.grab()
    return count / (time.perf_counter() - begin_s)


def growth_mb_per_h(minutes: List[float], memory_mb: List[float]) -> float:
    """Return the slope of a straight line through the figures."""
    middle, mean = statistics.mean(minutes), statistics.mean(memory_mb)
    spread = sum((one - middle) ** 2 for one in minutes)
    slope = sum((a - middle) * (b - mean) for a, b in zip(minutes, memory_mb)) / spread
    return slope * 60.0


def one_minute(
    interface: UserInterface, operator: Operator, tabs: List[TabName], rest: bool
) -> int:
    """Let the surveys go on and look at the tabs; return how many surveys were started."""
    started = 0
    end_s = time.monotonic() + 60.0
    tabs = list(tabs)
    while time.monotonic() < end_s:
        if operator.code in ENDED and not rest:
            operator.start()
            started += 1
        interface.window.show_tab(tabs[0])
        tabs.append(tabs.pop(0))
        run_events(min(TAB_S, max(0.01, end_s - time.monotonic())))
    return started


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=int, default=10)
    parser.add_argument("--time-scale", type=float, default=50.0)
    parser.add_argument("--tab", choices=[tab.value for tab in TabName], help="show only this one")
    parser.add_argument("--rest", action="store_true", help="start no survey")
    parser.add_argument("--plain", action="store_true", help="measure the processor time only")
    arguments = parser.parse_args()
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        os.environ["OPENBLAS_NUM_THREADS"] = "1"
        os.execv(sys.executable, [sys.executable, *sys.argv])
    tabs = list(TabName) if arguments.tab is None else [TabName(arguments.tab)]
    with virtual_screen(), simulated_robot(f"time_scale:={arguments.time_scale}") as robot:
        application = QApplication([])
        rospy.init_node("window_benchmark", disable_signals=True)
        languages = Languages(application, Language.ENGLISH)
        interface = new_window(languages, robot.data)
        interface.begin()
        operator = Operator()
        run_until(lambda: operator.code >= 0, "main_control is there", START_LIMIT_S)
        watch(interface, operator, tabs, arguments)
        interface.end()
        rospy.signal_shutdown("measured")


def watch(
    interface: UserInterface,
    operator: Operator,
    tabs: List[TabName],
    arguments: argparse.Namespace,
) -> None:
    print("minute  memory MB  objects  core %  away > 50 ms  longest ms  traces/s  surveys")
    heartbeat, delays, surveys = Heartbeat(), Delays(interface, arguments.plain), 0
    if not arguments.plain:
        heartbeat.start()
    at, memory_mb, cores = [], [], []
    for minute in range(1, arguments.minutes + 1):
        heartbeat.gaps_s.clear()
        begin_s, used_s, traces = time.monotonic(), processor_s(), delays.traces
        surveys += one_minute(interface, operator, tabs, arguments.rest)
        core = (processor_s() - used_s) / (time.monotonic() - begin_s)
        late = sum(1 for gap in heartbeat.gaps_s if gap > FRAME_S)
        at.append(float(minute))
        memory_mb.append(resident_mib())
        cores.append(core)
        print(
            f"{minute:6d} {memory_mb[-1]:10.1f} {len(gc.get_objects()):8d} "
            f"{100 * core:7.1f} {late:13d} "
            f"{1e3 * max(heartbeat.gaps_s, default=0.0):11.1f} "
            f"{(delays.traces - traces) / 60.0:9.1f} {surveys:8d}",
            flush=True,
        )
    print(f"core, mean: {100 * statistics.mean(cores):.1f} %")
    if delays.delays_s and len(tabs) == 1:
        low, high = np.percentile(delays.delays_s, [50.0, 99.0])
        print(
            f"from the topic to the screen, {len(delays.delays_s)} traces: median {low:.3f} s, "
            f"99th percentile {high:.3f} s, at most {max(delays.delays_s):.3f} s"
        )
    for tab in TabName:
        interface.window.show_tab(tab)
        run_events(0.5)
        print(f"{tab.value:8s} drawn whole {frames_per_s(interface.window):6.0f} times a second")
    if arguments.minutes > WARM_UP_MINUTES + 1:
        growth = growth_mb_per_h(at[WARM_UP_MINUTES:], memory_mb[WARM_UP_MINUTES:])
        print(f"memory from minute {WARM_UP_MINUTES + 1} on: {growth:+.1f} MB per hour")


if __name__ == "__main__":
    main()
