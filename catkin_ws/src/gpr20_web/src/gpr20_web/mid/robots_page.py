"""ROBOTS: every robot of the ROS master, what it does, and which one this page shows."""

from __future__ import annotations

import math
from typing import Any, Dict, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.robots import ListedRobot, RobotReported, Robots
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, Snapshot
from gpr20_web.calls import Call, Role, Route
from gpr20_web.mid.web_page import Interest, WebPage


class RobotsPage(WebPage):
    """Listens to the other robots while somebody looks at the list."""

    words: Mapping[str, Message] = {
        "title": Message("Robots"),
        "name": Message("Name"),
        "state": Message("State"),
        "shown": Message("shown on this page"),
    }

    def __init__(self, robots: Robots, clock: Clock) -> None:
        self._robots, self._now_s = robots, clock.now_s
        self._snapshot: Optional[Snapshot] = None
        # When each robot has said something, by its namespace.
        self._heard_s: Dict[str, float] = {}
        self._interest = Interest(self._follow, clock)
        self.routes = (Route("GET", "/api/robots", Role.WATCH, self._list),)

    def on_event(self, event: object) -> None:
        """Follow the robots of the master."""
        self._robots.take(event)
        if isinstance(event, RobotReported):
            self._heard_s[event.namespace] = self._now_s()

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot of this page."""
        self._snapshot = snapshot
        self._interest.refresh()

    def _follow(self, follows: bool) -> None:
        # What a robot did before nobody listened is not what it does now.
        self._heard_s.clear()
        self._robots.watch(follows)

    def _list(self, call: Call) -> Mapping[str, Any]:
        self._interest.ask()
        listed = self._robots.listed
        if not any(one.is_shown for one in listed):
            listed = (self._robots.shown, *listed)
        return {"robots": [self._row(one, call) for one in listed]}

    def _row(self, robot: ListedRobot, call: Call) -> Mapping[str, Any]:
        silent_s = self._now_s() - self._heard_s.get(robot.namespace, -math.inf)
        condition = robot.condition if silent_s <= CONTROL_SILENCE_S else None
        if robot.is_shown and self._snapshot is not None:
            condition = condition_of(self._snapshot)
        title = Message("no report yet") if condition is None else condition.title
        level = JobLevel.REST if condition is None else condition.level
        return {
            "name": robot.namespace.strip("/") or call.text(Message("Robot")),
            "level": level.value,
            "title": call.text(title),
            "shown": robot.is_shown,
        }
