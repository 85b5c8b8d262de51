"""The page at a distance on the whole simulated robot: processor time and memory of its node.

    scripts/bench.sh web                       (without and with watchers, and a real browser)
    scripts/bench.sh web --minutes 30          (memory while watchers come and go)

Surveys of the simulated robot follow each other. The watchers read the live document over TLS, each
with a session of its own, in one separate process; the browser is Debian's Chromium without a
screen, which shows NOW. Shares are user and system time of the processes in per cent of one core.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import tempfile
import time
from pathlib import Path
from typing import Callable, ContextManager, Dict, Iterator, List, Optional

import psutil
import rospy
from browser_kit import Browser
from graph_kit import PERCENT, print_table, processor_s
from page_kit import NAME, PASSWORD, Page, new_page, watchers
from robot_kit import WEB, LaunchedRobot, resident_mib, simulated_robot
from window import ENDED, WARM_UP_MINUTES, growth_mb_per_h
from window_kit import Operator

POLL_S = 0.1
SETTLE_S, SAMPLE_S = 5.0, 1.0
STAY_S = 20.0
COLUMNS = ("watching", "traces a second", "node %", "watchers %", "browser %", "load average")


class Robot:
    """The robot under load.

    Attributes:
        traces: How many were measured so far.
    """

    def __init__(self, launched: LaunchedRobot) -> None:
        self.web = launched.processes()[WEB]
        self.operator, self.traces, self.surveys = Operator(), 0, 0
        self._subscriber = rospy.Subscriber("trace", rospy.AnyMsg, self._count)

    def survey(self, duration_s: float, rest: bool) -> None:
        """Let surveys follow each other for a while, or rest."""
        end_s = time.monotonic() + duration_s
        while time.monotonic() < end_s:
            if self.operator.code in ENDED and not rest:
                self.operator.start()
                self.surveys += 1
            time.sleep(POLL_S)

    def _count(self, _message: rospy.AnyMsg) -> None:
        self.traces += 1


@contextlib.contextmanager
def chromium(page: Page) -> Iterator[psutil.Process]:
    """Show NOW in a browser; yield its first process."""
    browser = Browser(keeps_logs=False)
    try:
        browser.open(f"https://localhost:{page.port}/")
        browser.write("input[name=name]", NAME)
        browser.write("input[name=password]", PASSWORD)
        browser.press("form button.primary")
        browser.find("#state")
        (found,) = psutil.Process(browser.driver.service.process.pid).children()
        yield found
    finally:
        browser.close()


@contextlib.contextmanager
def many(page: Page, count: int, stay_s: float = 0.0) -> Iterator[psutil.Process]:
    """Let many watch; yield their process."""
    with watchers(page, count, stay_s) as process:
        yield psutil.Process(process.pid)


def shares(robot: Robot, others: Dict[str, psutil.Process], duration_s: float, rest: bool) -> list:
    """Return the figures of a row."""
    robot.survey(SETTLE_S, rest)
    measured = {"node": robot.web, **others}
    before = {name: processor_s(one) for name, one in measured.items()}
    begin_s, traces = time.monotonic(), robot.traces
    robot.survey(duration_s, rest)
    took_s = time.monotonic() - begin_s
    found = {n: PERCENT * (processor_s(p) - before[n]) / took_s for n, p in measured.items()}
    cells = [f"{found[n]:.2f}" if n in found else "-" for n in ("node", "watchers", "browser")]
    load = f"{os.getloadavg()[0]:.1f}"
    return [f"{(robot.traces - traces) / took_s:.1f}", *cells, load]


def measure(robot: Robot, page: Page, arguments: argparse.Namespace) -> List[List[str]]:
    count, rows = arguments.watchers, []
    kinds: Dict[str, Optional[Callable[[], ContextManager[psutil.Process]]]] = {
        "nobody": None,
        "watchers": lambda: many(page, count),
        "browser": lambda: chromium(page),
    }
    for rest in (True, False):
        for name, enter in kinds.items():
            others: Dict[str, psutil.Process] = {}
            with contextlib.ExitStack() as stack:
                if enter is not None:
                    others[name] = stack.enter_context(enter())
                row = shares(robot, others, arguments.seconds, rest)
            label = f"{count} watchers" if name == "watchers" else name
            rows.append([f"{label}, {'no survey' if rest else 'surveys'}", *row])
            print(*rows[-1], sep="  ", flush=True)
    return rows


def follow_memory(robot: Robot, page: Page, arguments: argparse.Namespace) -> None:
    """Print the memory of the node, minute by minute."""
    at: List[float] = []
    memory_mib: List[float] = []
    with many(page, arguments.watchers, STAY_S):
        print("minute  memory MiB  node %  traces/s  surveys")
        for minute in range(1, arguments.minutes + 1):
            used_s, traces, begin_s = processor_s(robot.web), robot.traces, time.monotonic()
            sizes_mib = []
            while time.monotonic() - begin_s < 60.0:
                robot.survey(SAMPLE_S, False)
                sizes_mib.append(resident_mib(robot.web.pid))
            took_s = time.monotonic() - begin_s
            at.append(float(minute))
            # The least: each check of a password takes 32 MiB for a moment.
            memory_mib.append(min(sizes_mib))
            print(
                f"{minute:6d} {memory_mib[-1]:11.1f} "
                f"{PERCENT * (processor_s(robot.web) - used_s) / took_s:7.2f} "
                f"{(robot.traces - traces) / took_s:9.1f} {robot.surveys:8d}",
                flush=True,
            )
    if arguments.minutes > WARM_UP_MINUTES + 1:
        growth = growth_mb_per_h(at[WARM_UP_MINUTES:], memory_mib[WARM_UP_MINUTES:])
        print(f"memory from minute {WARM_UP_MINUTES + 1} on: {growth:+.1f} MiB per hour")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--watchers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0, help="duration of each row")
    parser.add_argument("--time-scale", type=float, default=122.0)
    parser.add_argument("--minutes", type=int, default=0, help="follow the memory so long")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gpr20_web_") as folder:
        page = new_page(Path(folder))
        options = (f"time_scale:={arguments.time_scale:g}", *page.options)
        with simulated_robot(*options) as launched:
            rospy.init_node("web_benchmark", disable_signals=True)
            robot = Robot(launched)
            if arguments.minutes:
                follow_memory(robot, page, arguments)
            else:
                print_table(COLUMNS, measure(robot, page, arguments))
            rospy.signal_shutdown("measured")


if __name__ == "__main__":
    main()
