"""The page over a link that is bad and cut: nothing old is ever shown as if it were live.

Robot and page are in one network namespace, the browser is in another one; this file is also the
program of each. The figures of docs/evidence/web_page.md:
pytest -s -m release scripts/test/test_web_link.py
"""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import List, NamedTuple, Optional

import pytest
import rospy
from bad_link import BadLink, LinkQuality, enter
from browser_kit import Browser
from network_namespaces import SERVER, badly_linked_machines
from page_kit import NAME, PASSWORD, new_page
from robot_kit import simulated_robot
from window_kit import Operator

from gpr20_common.low.clock import Clock
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.robot.condition import condition_of
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.snapshot import progress_of
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.plan.survey_state import ENDED

MINUTES = float(os.environ.get("GPR20_LINK_MINUTES", "2.5"))
QUALITY = LinkQuality(0.1, 0.0, 0.05, 1)
OLD_S, LOOK_S, NOTE_S = 5.0, 0.1, 0.05
# From when to when a survey is stopped, the link works, and is cut [s].
SURVEY_S, UP_S, DOWN_S = (5.0, 20.0), (15.0, 30.0), (2.0, 12.0)
LOOK = """
const text = (selector) => document.querySelector(selector)?.innerText ?? "";
return [document.body.classList.contains("stale"), text("#state"), text("dl")];
"""
STORED = re.compile(r"(\d+) of \d+ traces")


class Shown(NamedTuple):
    """What a person reads, or would read without a link; times of time.monotonic()."""

    begin_s: float
    end_s: float
    title: str
    stored: Optional[int]
    is_stale: bool = False


class Truth:
    """What is true at the robot, noted again and again."""

    def __init__(self) -> None:
        self._model = SurveyModel(Clock())
        self._control = ControlClient(self._model.handle, Senders("/"))
        self._control.listen()
        self._control.set_watched(True)
        self.noted: List[Shown] = []
        threading.Thread(target=self._note, daemon=True).start()

    def _note(self) -> None:
        while True:
            snapshot, now_s = self._model.snapshot(), time.monotonic()
            progress = progress_of(snapshot)
            stored = None if progress is None else progress.visited_points
            self.noted.append(Shown(now_s, now_s, str(condition_of(snapshot).title), stored))
            time.sleep(NOTE_S)

    def was_lately(self, shown: Shown) -> bool:
        """Return whether title and number that were shown have been true less than 5 s before."""
        lately = [one for one in self.noted if shown.begin_s - OLD_S <= one.begin_s <= shown.end_s]
        numbers = [one.stored for one in lately if one.stored is not None]
        known = any(one.stored is None for one in lately)
        if shown.stored is not None:
            known = bool(numbers) and min(numbers) <= shown.stored <= max(numbers)
        return known and any(shown.title.startswith(one.title) for one in lately)


def browse(address: str) -> None:
    """Print what the browser shows until it is asked to end."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    browser = Browser()
    try:
        browser.open(address)
        browser.write("input[name=name]", NAME)
        browser.write("input[name=password]", PASSWORD)
        browser.press("form button.primary")
        browser.find("#state")
        while True:
            begin_s = time.monotonic()
            is_stale, title, figures = browser.run(LOOK)
            found = STORED.search(figures)
            stored = int(found.group(1)) if found else None
            print(json.dumps([begin_s, time.monotonic(), title, stored, is_stale]), flush=True)
            time.sleep(LOOK_S)
    except KeyboardInterrupt:
        return
    finally:
        browser.close()


def run(link: BadLink, drawn: random.Random) -> None:
    """Let surveys and the link begin and end."""
    operator, is_up, stop_s = Operator(), True, float("inf")
    end_s = time.monotonic() + 60.0 * MINUTES
    change_s = time.monotonic() + UP_S[0]
    while time.monotonic() < end_s:
        now_s = time.monotonic()
        if operator.code in ENDED:
            operator.start()
            stop_s = now_s + drawn.uniform(*SURVEY_S)
        elif now_s > stop_s:
            operator.stop()
            stop_s = float("inf")
        if now_s > change_s:
            is_up = not is_up
            link.restore() if is_up else link.cut()
            change_s = now_s + drawn.uniform(*(UP_S if is_up else DOWN_S))
        time.sleep(NOTE_S)


def main() -> None:
    """Print how many moments the browser showed as live, and which of them were old."""
    with badly_linked_machines(QUALITY) as (here, there, link), tempfile.TemporaryDirectory() as at:
        enter(here.name)
        page = new_page(Path(at), SERVER)
        with simulated_robot("time_scale:=30", *page.options):
            rospy.init_node("link_test", disable_signals=True)
            truth = Truth()
            program = [sys.executable, __file__, f"https://{SERVER}:{page.port}/"]
            browser = subprocess.Popen([*there.prefix, *program], stdout=subprocess.PIPE, text=True)
            lines = iter(browser.stdout.readline, "")
            looked = [Shown(*json.loads(next(lines)))]
            reader = threading.Thread(
                target=lambda: looked.extend(Shown(*json.loads(one)) for one in lines), daemon=True
            )
            reader.start()
            run(link, random.Random(QUALITY.seed))
            live = [one for one in looked if not one.is_stale]
            old = [one for one in live if not truth.was_lately(one)]
            browser.terminate()
            browser.wait()
    print(json.dumps({"moments": len(looked), "live": len(live), "old": old}))


@pytest.mark.release
@pytest.mark.needs("network namespaces", "tun")
@pytest.mark.timeout(1200)
def test_nothing_old_is_shown_as_live_over_a_link_that_is_cut():
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    ended = subprocess.run(
        [sys.executable, __file__], env=environment, stdout=subprocess.PIPE, check=True
    )
    found = json.loads(ended.stdout)
    print(f"\n{found['moments']} moments, {found['live']} of them live")
    assert found["live"] > 100 and found["moments"] > found["live"]
    assert found["old"] == []


if __name__ == "__main__":
    browse(sys.argv[1]) if len(sys.argv) > 1 else main()
