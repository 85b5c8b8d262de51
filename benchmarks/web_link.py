"""The page over a bad link: whether something old is ever shown as if it were live. Needs root.

    scripts/bench.sh web_link --minutes 3

Robot and page are in one network namespace, Debian's Chromium, which shows NOW, in another one. The
link between them (scripts/test/bad_link.py) delays and loses packets, and is cut now and then.
Surveys are started and stopped at random. Ten times a second, the state and the number of stored
traces that a person reads are compared with what was true: they must have been true at most 5 s
before, or the page says that they are old.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, List, Optional, Tuple

import rospy
from browser_kit import Browser
from graph_kit import ROOT
from page_kit import NAME, PASSWORD, new_page
from robot_kit import simulated_robot
from window import ENDED
from window_kit import Operator

from gpr20_common.low.clock import Clock
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.robot.condition import condition_of
from gpr20_operator.robot.job import progress_of
from gpr20_operator.robot.senders import Senders
from gpr20_operator.robot.survey_model import SurveyModel

sys.path.append(str(ROOT / "scripts/test"))
from bad_link import CLONE_NEWNET, BadLink, LinkQuality
from network_namespaces import SERVER, badly_linked_machines

OLD_S = 5.0
LOOK_S, NOTE_S, REST_S = 0.1, 0.05, 3.0
# From when to when a survey is stopped, the link works, and is cut [s].
SURVEY_S, UP_S, DOWN_S = (5.0, 20.0), (15.0, 30.0), (2.0, 12.0)
LOOK = """
const text = (selector) => document.querySelector(selector)?.innerText ?? "";
return [document.body.classList.contains("stale"), text("#state"), text("dl")];
"""
STORED = re.compile(r"(\d+) of \d+ traces")


@dataclass(frozen=True)
class Shown:
    """What a person reads, or would read if there were no link; times of time.monotonic() [s]."""

    begin_s: float
    end_s: float
    title: str
    stored: Optional[int]
    is_stale: bool = False


def browse(address: str) -> None:
    """Print what the browser shows until standard input ends."""
    browser = Browser()
    try:
        browser.open(address)
        browser.write("input[name=name]", NAME)
        browser.write("input[name=password]", PASSWORD)
        browser.press("form button.primary")
        browser.find("#state")
        ended = threading.Event()

        def wait_for_end() -> None:
            sys.stdin.read()
            ended.set()

        threading.Thread(target=wait_for_end, daemon=True).start()
        while not ended.wait(LOOK_S):
            begin_s = time.monotonic()
            is_stale, title, figures = browser.run(LOOK)
            found = STORED.search(figures)
            stored = int(found.group(1)) if found else None
            print(json.dumps([begin_s, time.monotonic(), title, stored, is_stale]), flush=True)
    finally:
        browser.close()


class Truth:
    """What is true at the robot, as often as it is noted."""

    def __init__(self) -> None:
        self._model = SurveyModel(Clock())
        self._control = ControlClient(self._take, Senders("/"))
        self._control.listen()
        self._control.set_watched(True)
        self.noted: List[Shown] = []

    def _take(self, event: object) -> None:
        self._model.handle(event)

    def note(self) -> None:
        """Note what is true, in a thread of its own, until this program ends."""
        while True:
            self._note()
            time.sleep(NOTE_S)

    def _note(self) -> None:
        snapshot, now_s = self._model.snapshot(), time.monotonic()
        progress = progress_of(snapshot)
        stored = None if progress is None else progress.visited_points
        self.noted.append(Shown(now_s, now_s, str(condition_of(snapshot).title), stored))


def age_s(shown: Shown, noted: List[Shown], same: Callable[[Shown, Shown], bool]) -> float:
    """Return how long something has not been true when it was read; infinite: it never was."""
    for before, after in reversed(list(zip(noted, noted[1:]))):
        if before.begin_s <= shown.end_s and same(before, after):
            return max(0.0, shown.begin_s - after.begin_s)
    return math.inf


def ages_s(shown: Shown, noted: List[Shown]) -> Tuple[float, float]:
    """Return the ages of the state and of the number of traces."""

    def same_number(before: Shown, after: Shown) -> bool:
        # Between two notes, traces may have been stored, or a survey may have begun.
        known = [one.stored for one in (before, after)]
        numbers = [one for one in known if one is not None]
        if shown.stored is None:
            return None in known
        return bool(numbers) and min(numbers) <= shown.stored <= max(numbers)

    def same_title(before: Shown, after: Shown) -> bool:
        return shown.title.startswith((before.title, after.title))

    return age_s(shown, noted, same_title), age_s(shown, noted, same_number)


def run(link: BadLink, duration_s: float, cuts: bool, seed: int) -> List[float]:
    """Let surveys and the link begin and end; return when the link was restored [s]."""
    drawn, operator, restored = random.Random(seed), Operator(), []
    end_s = time.monotonic() + duration_s
    stop_s = ended_s = math.inf
    change_s, is_up = time.monotonic() + UP_S[1], True
    while time.monotonic() < end_s:
        now_s = time.monotonic()
        ended_s = min(ended_s, now_s) if operator.code in ENDED else math.inf
        if now_s - ended_s > REST_S:
            operator.start()
            stop_s, ended_s = now_s + drawn.uniform(*SURVEY_S), math.inf
        elif now_s > stop_s:
            operator.stop()
            stop_s = math.inf
        if cuts and now_s > change_s:
            is_up = not is_up
            change_s = now_s + drawn.uniform(*(UP_S if is_up else DOWN_S))
            if is_up:
                link.restore()
                restored.append(now_s)
            else:
                link.cut()
        time.sleep(NOTE_S)
    return restored


def report(looked: List[Shown], noted: List[Shown], restored: List[float]) -> None:
    live = [one for one in looked if not one.is_stale]
    found = [max(ages_s(one, noted)) for one in live]
    old = [age for age in found if age > OLD_S]
    print(
        f"{len(looked)} moments, {len(live)} of them shown as live: {len(old)} of these older than "
        f"{OLD_S:g} s, at most {max(found):.2f} s, median {sorted(found)[len(found) // 2]:.2f} s"
    )
    for when_s in restored:
        after = (one.begin_s - when_s for one in live if one.begin_s > when_s)
        print(f"live again {next(after, math.nan):.1f} s after a cut")
    for one, age in zip(live, found):
        if age > OLD_S:
            print(f"  {age:.2f} s old: {one}")


def measure(chosen: argparse.Namespace) -> None:
    quality = LinkQuality(chosen.delay_s, 0.0, chosen.loss, chosen.seed)
    with badly_linked_machines(quality) as (here, there, link), tempfile.TemporaryDirectory() as at:
        enter(here.name)
        page = new_page(Path(at), SERVER)
        with simulated_robot("time_scale:=30", *page.options):
            rospy.init_node("link_benchmark", disable_signals=True)
            truth, looked = Truth(), []
            threading.Thread(target=truth.note, daemon=True).start()
            address = f"https://{SERVER}:{page.port}/"
            browser = subprocess.Popen(
                [*there.prefix, sys.executable, __file__, "--browse", address],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            printed, ending = browser.stdout, browser.stdin
            assert printed is not None and ending is not None
            looked.append(Shown(*json.loads(printed.readline())))
            reader = threading.Thread(
                target=lambda: looked.extend(Shown(*json.loads(one)) for one in printed)
            )
            reader.start()
            restored = run(link, chosen.minutes * 60.0, chosen.cuts, chosen.seed)
            ending.close()
            reader.join()
            rospy.signal_shutdown("measured")
        noted = list(truth.noted)
    begin_s, end_s = noted[0].begin_s + OLD_S, noted[-1].begin_s
    report([one for one in looked if begin_s < one.begin_s < end_s], noted, restored)


def enter(namespace: str) -> None:
    """Move this process, and those that it starts, into a network namespace."""
    with open(f"/run/netns/{namespace}") as file:
        if ctypes.CDLL(None).setns(file.fileno(), CLONE_NEWNET) != 0:
            raise SystemExit("the network namespace cannot be entered")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=3.0)
    parser.add_argument("--delay-s", type=float, default=0.1, help="in each direction")
    parser.add_argument("--loss", type=float, default=0.05)
    parser.add_argument("--cuts", action="store_true", help="cut the link now and then")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--browse", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.browse:
        browse(chosen.browse)
    elif os.geteuid() != 0:
        raise SystemExit("network namespaces need root")
    else:
        measure(chosen)


if __name__ == "__main__":
    main()
