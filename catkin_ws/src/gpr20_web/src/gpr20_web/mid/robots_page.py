"""ROBOTS: every robot of the ROS master, what it does, and which one this page shows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Dict, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.robots import ListedRobot, RobotReported, Robots
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, Snapshot
from gpr20_survey.trace.utc_time import US_PER_S, iso_text
from gpr20_web.calls import Call, Role, Route
from gpr20_web.mid.web_page import Interest, WebPage


@dataclass(frozen=True)
class _Report:
    """What a robot said last, when [s], and when it began to say that [us]; None: not known."""

    state: ControlState
    heard_s: float
    since_us: Optional[int] = None


class RobotsPage(WebPage):
    """Listens to the other robots while somebody looks at the list."""

    words: Mapping[str, Message] = {
        "title": Message("Robots"),
        "name": Message("Name"),
        "state": Message("State"),
        "since": Message("since {time}", time="{time}"),
        "shown": Message("shown on this page"),
    }

    def __init__(self, robots: Robots, clock: Clock) -> None:
        self._robots, self._clock = robots, clock
        self._snapshot: Optional[Snapshot] = None
        self._reports: Dict[str, _Report] = {}
        self._interest = Interest(self._follow, clock)
        self.routes = (Route("GET", "/api/robots", Role.WATCH, self._list),)

    def on_event(self, event: object) -> None:
        """Follow the robots of the master."""
        self._robots.take(event)
        if isinstance(event, RobotReported):
            known = self._reports.get(event.namespace)
            report = _Report(event.state, self._clock.now_s())
            if known is not None:
                same = known.state.code is event.state.code
                since_us = known.since_us if same else self._clock.time_of_day_us()
                report = replace(report, since_us=since_us)
            self._reports[event.namespace] = report

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot of this page."""
        self._snapshot = snapshot
        self._interest.refresh()

    def _follow(self, follows: bool) -> None:
        # What a robot did before nobody listened is not what it does now.
        self._reports.clear()
        self._robots.watch(follows)

    def _list(self, call: Call) -> Mapping[str, Any]:
        self._interest.ask()
        listed = self._robots.listed
        if not any(one.is_shown for one in listed):
            listed = (self._robots.shown, *listed)
        return {"robots": [self._row(one, call) for one in listed]}

    def _row(self, robot: ListedRobot, call: Call) -> Mapping[str, Any]:
        report, shown = self._reports.get(robot.namespace), self._snapshot
        condition, since_us = None, None
        if robot.is_shown and shown is not None:
            condition = condition_of(shown)
            if shown.control_alive and math.isfinite(shown.state_s):
                since_us = self._clock.time_of_day_us() - int(shown.state_s * US_PER_S)
        elif report is not None and self._clock.now_s() - report.heard_s <= CONTROL_SILENCE_S:
            condition, since_us = replace(robot, state=report.state).condition, report.since_us
        title = replace(robot, state=None).activity if condition is None else condition.title
        level = JobLevel.REST if condition is None else condition.level
        return {
            "name": robot.name,
            "level": level.value,
            "title": call.text(title),
            "since": "" if since_us is None else iso_text(since_us),
            "shown": robot.is_shown,
        }
