"""The whole table of routes: every page with what it works with, whoever carries them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.ground.traces import TraceSource
from gpr20_operator.jobs.job import Requests
from gpr20_operator.robot.robots import Robots
from gpr20_web.low.accounts import Accounts
from gpr20_web.low.cookies import Logins
from gpr20_web.low.notifier import News
from gpr20_web.mid.commands import Commands
from gpr20_web.mid.ground_page import GroundPage
from gpr20_web.mid.login_page import LoginPage
from gpr20_web.mid.now_page import NowPage
from gpr20_web.mid.robots_page import RobotsPage
from gpr20_web.mid.service_page import ServicePage
from gpr20_web.mid.surveys_page import SurveyServices, SurveysPage
from gpr20_web.mid.watch import Watch
from gpr20_web.mid.web_page import WebPage


@dataclass(frozen=True)
class Surroundings:
    """What the pages work with; all that reaches the robot or its files is here.

    Attributes:
        name: Of the robot, where there are several; else empty.
        data: Folder of the surveys.
        watch: As for `ServiceModel`.
        examine: As for `ServiceModel`.
        make_bundle: Makes the bundle for remote help, and waits.
        send: Takes notices for those who have no page open.
        warn: Takes what cannot be shown.
    """

    name: str
    data: Path
    clock: Clock
    accounts: Accounts
    logins: Logins
    commands: Commands
    source: TraceSource
    requests: Requests
    services: SurveyServices
    robots: Robots
    watch: Callable[[bool], None]
    examine: Callable[..., Any]
    make_bundle: Callable[[], bytes]
    send: Callable[[News], None]
    warn: Callable[[Message], None]


def all_pages(given: Surroundings) -> Dict[str, WebPage]:
    """Return the pages by the names under which their scripts ask for words."""
    clock = given.clock
    ground = GroundPage(given.source, given.requests, clock.now_s, given.warn)
    return {
        "now": NowPage(given.name),
        "commands": given.commands,
        "map": ground,
        "surveys": SurveysPage(given.services, given.data),
        "robots": RobotsPage(given.robots, clock),
        "service": ServicePage(given.watch, given.examine, given.make_bundle, clock),
        "notices": Watch(clock, given.send, ground.picture),
        "login": LoginPage(given.accounts, given.logins, clock),
    }
