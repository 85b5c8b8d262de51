"""The real window on the whole simulated robot: memory, processor time, how fluent it is.

Surveys of the simulated robot follow each other at full speed while the window shows one tab
after the other, and each axis publishes at 50 Hz while it moves. Everything of the window runs in
this process, so its own counters are those of the window.

    scripts/bench.sh window_load --minutes 120        (memory over two hours)

A heartbeat of 10 ms measures how long the window's thread was busy with something else: beyond
50 ms it could not have drawn 20 frames a second.
"""

from __future__ import annotations

import argparse
import gc
import resource
import statistics
import time
from typing import List

import rospy
from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import QApplication, QWidget
from robot_kit import resident_mib, simulated_robot
from window_kit import (
    Operator,
    new_window,
    run_events,
    run_until,
    virtual_screen,
)

from gpr20_common.catalogue import Language
from gpr20_msgs.msg import ControlStatus
from gpr20_user_interface.high.user_interface import UserInterface
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.translation import Languages

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
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._beat)
        self._timer.start(HEARTBEAT_MS)

    def _beat(self) -> None:
        now_s = time.monotonic()
        self.gaps_s.append(now_s - self._last_s)
        self._last_s = now_s


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


def one_minute(interface: UserInterface, operator: Operator) -> int:
    """Let the surveys go on and look at each tab; return how many surveys were started."""
    started = 0
    end_s = time.monotonic() + 60.0
    tabs = list(TabName)
    while time.monotonic() < end_s:
        if operator.code in ENDED:
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
    arguments = parser.parse_args()
    with virtual_screen(), simulated_robot(f"time_scale:={arguments.time_scale}") as robot:
        application = QApplication([])
        rospy.init_node("window_load", disable_signals=True)
        languages = Languages(application, Language.ENGLISH)
        interface = new_window(languages, robot.data)
        interface.begin()
        operator = Operator()
        run_until(lambda: operator.code >= 0, "main_control is there", START_LIMIT_S)
        watch(interface, operator, arguments.minutes)
        interface.end()
        rospy.signal_shutdown("measured")


def watch(interface: UserInterface, operator: Operator, minutes: int) -> None:
    print("minute  memory MB  objects  core %  away > 50 ms  longest ms  traces shown  surveys")
    heartbeat, surveys = Heartbeat(), 0
    at, memory_mb, cores = [], [], []
    for minute in range(1, minutes + 1):
        heartbeat.gaps_s.clear()
        begin_s, used_s = time.monotonic(), processor_s()
        surveys += one_minute(interface, operator)
        core = (processor_s() - used_s) / (time.monotonic() - begin_s)
        late = sum(1 for gap in heartbeat.gaps_s if gap > FRAME_S)
        at.append(float(minute))
        memory_mb.append(resident_mib())
        cores.append(core)
        print(
            f"{minute:6d} {memory_mb[-1]:10.1f} {len(gc.get_objects()):8d} "
            f"{100 * core:7.1f} {late:13d} "
            f"{1e3 * max(heartbeat.gaps_s):11.1f} {interface.window.traces.live.radar.count:13d} "
            f"{surveys:8d}",
            flush=True,
        )
    print(f"core, mean: {100 * statistics.mean(cores):.1f} %")
    for tab in TabName:
        interface.window.show_tab(tab)
        run_events(0.5)
        print(f"{tab.value:8s} drawn whole {frames_per_s(interface.window):6.0f} times a second")
    if minutes > WARM_UP_MINUTES + 1:
        growth = growth_mb_per_h(at[WARM_UP_MINUTES:], memory_mb[WARM_UP_MINUTES:])
        print(f"memory from minute {WARM_UP_MINUTES + 1} on: {growth:+.1f} MB per hour")


if __name__ == "__main__":
    main()
