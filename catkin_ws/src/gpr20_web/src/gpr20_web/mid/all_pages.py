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
from gpr20_web.mid.accounts import Accounts
from gpr20_web.mid.audit import Audit
from gpr20_web.mid.candidate_search import SurveyServices
from gpr20_web.mid.commands import Commands
from gpr20_web.mid.controller import Controller, ControlPage
from gpr20_web.mid.ground_page import GroundPage, MapPage, RadarPage
from gpr20_web.mid.login_limits import LoginLimits
from gpr20_web.mid.login_page import LoginPage
from gpr20_web.mid.now_page import NowPage
from gpr20_web.mid.robots_page import RobotsPage
from gpr20_web.mid.service_page import ServicePage
from gpr20_web.mid.sessions import Sessions
from gpr20_web.mid.surveys_page import SurveysPage
from gpr20_web.mid.watch import Watch
from gpr20_web.mid.web_page import WebPage
from gpr20_web.news import News

InBackground = Callable[[Callable[[], None]], None]


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
    sessions: Sessions
    audit: Audit
    commands: Commands
    controller: Controller
    source: TraceSource
    requests: Requests
    services: SurveyServices
    in_background: InBackground
    robots: Robots
    watch: Callable[[bool], None]
    examine: Callable[..., Any]
    make_bundle: Callable[[], bytes]
    send: Callable[[News], None]
    warn: Callable[[Message], None]


def all_pages(given: Surroundings) -> Dict[str, WebPage]:
    """Return the pages by the names under which their scripts ask for words."""
    clock, audit = given.clock, given.audit.add
    ground = GroundPage(given.source, given.requests, clock.now_s, given.warn)
    return {
        "now": NowPage(given.name),
        "commands": given.commands,
        "control": ControlPage(given.controller, clock, audit),
        "ground": ground,
        "map": MapPage(),
        "radar": RadarPage(),
        "surveys": SurveysPage(given.services, given.data, audit, given.in_background),
        "robots": RobotsPage(given.robots, clock),
        "service": ServicePage(given.watch, given.examine, given.make_bundle, audit, clock),
        "notices": Watch(clock, given.send, ground.picture),
        "login": LoginPage(given.accounts, given.sessions, LoginLimits(clock), audit),
    }
