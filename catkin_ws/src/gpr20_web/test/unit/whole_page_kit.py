"""The whole table of routes without ROS: real accounts, sessions and surveys, fakes for the robot.

Every fake records what it is asked, so that a test sees whether a request has done something.
"""

from __future__ import annotations

import logging
import socket
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Tuple

from asked_storage import Storage
from result_kit import Requests
from surveys_kit import Surveys
from test_commands import PLAN, Control
from view_kit import SURVEY, depth_echo, description, trace_at
from web_ground_kit import PLANNED
from web_kit import (
    LIMIT_S,
    PASSWORD,
    STATIC,
    ManualClock,
    Reply,
    Site,
    make_accounts,
    make_logins,
    state_of,
)

from gpr20_common.message import Message
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.grid import grid_from_description
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.remote_control import RemoteAllowance, RemoteArmed
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Person, Role
from gpr20_web.faults import NOT_ALLOWED, NOT_LOGGED_IN
from gpr20_web.mid.commands import Commands, plan_id
from gpr20_web.mid.ground_page import GroundPage
from gpr20_web.mid.presses import Lease
from gpr20_web.mid.robot_pages import NowPage, ServicePage
from gpr20_web.mid.shell import Shell
from gpr20_web.mid.surveys_page import SurveysPage

PEOPLE = {Role.WATCH: "vera", Role.CONTROL: "otto"}
ADDRESS = "127.0.0.1"


class WholePage:
    """The node without ROS, at a port of its own.

    Attributes:
        foreign: Exceptions that no error of the project is, whoever has caught them.
    """

    def __init__(self, folder: Path) -> None:
        self.clock, self.folder = ManualClock(), folder
        self.surveys = Surveys(folder / "data")
        self.control, self.storage, self.requests = Control(), Storage(), Requests()
        self.accounts = make_accounts(folder)
        self.logins = make_logins(self.accounts, self.clock)
        self._tokens: Dict[Role, str] = {}
        self.model = SurveyModel(self.clock)
        self.lease = Lease(self.clock, lambda _session: True)
        commands = Commands(
            *(self.model, self.control, RemoteAllowance(self.clock)),
            *(self.clock, self.lease, lambda *_note: None),
        )
        self.shell = self._new_shell(commands)
        self._measure()
        self.routes = tuple(self.shell.all_routes())
        self.files = self.shell.files(STATIC)
        self.site = Site(self.routes, self.logins.find, self.files)
        self.foreign: List[Any] = self.site.reported
        # What a library calls an error: an exception that nobody has taken.
        self._errors = logging.Handler(logging.ERROR)
        self._errors.emit = self.foreign.append  # type: ignore[method-assign]
        logging.getLogger().addHandler(self._errors)
        self.renew()
        self.be(SurveyState.CONFIGURED)

    def _new_shell(self, commands: Commands) -> Shell:
        """Return the pages as the node has them."""
        nothing: Any = lambda *_arguments, **_more: None  # noqa: E731
        return Shell(
            {
                "now": NowPage(""),
                "commands": commands,
                "map": GroundPage(self.storage, self.requests, self.clock.now_s, nothing),
                "surveys": SurveysPage(self.surveys.services, self.surveys.data),
                "service": ServicePage(nothing, self.clock),
            },
            self.logins,
        )

    def close(self) -> None:
        self.site.close()
        logging.getLogger().removeHandler(self._errors)
        self.surveys.close()

    def _measure(self) -> None:
        """Let the ground of the running survey be known."""
        grid = grid_from_description(description())
        self.shell.on_event(SurveyDescribed(description()))
        self.shell.on_event(CoverageRuns(SURVEY, PLANNED, (0,), (1,)))
        for index in range(PLANNED):
            self.shell.on_event(trace_at(grid, index, s21=depth_echo(0.1)))

    def be(self, code: SurveyState, armed: bool = True) -> None:
        """Let the robot be in a state, and somebody beside it allow START and RESUME."""

        async def take() -> None:
            # Nothing is asked for any more, and the last survey has ended.
            events = [
                *(Answer(one, False, Message("no")) for one in Request),
                *(AxisStopAnswer(axis, True) for axis in AxisId),
                *(AxisReport(axis, 0.0, True, False) for axis in AxisId),
                *(state_of(one, survey=SURVEY) for one in (SurveyState.STOPPED, code)),
                RemoteArmed(armed, 600.0, PLAN),
            ]
            for event in events:
                # A report proves that an axis rests a moment after the answers to STOP.
                self.clock.time_s += 0.3 if isinstance(event, AxisReport) else 0.0
                self.model.handle(event)
                self.shell.on_event(event)
                self.shell.refresh(self.model.snapshot())

        self.site.call(take())

    def wait(self, seconds: float) -> None:
        self.clock.time_s += seconds

        async def refresh() -> None:
            self.shell.refresh(self.model.snapshot())

        self.site.call(refresh())

    def renew(self) -> None:
        """Let everybody have an account with the known password, and be logged in."""
        for role, name in PEOPLE.items():
            # Whoever has another password or role is logged out.
            if not self.is_logged_in(role):
                self.accounts.put(name, role, PASSWORD)
                self._tokens[role] = self.logins.begin(name, PASSWORD, ADDRESS).session

    def session(self, role: Role) -> str:
        """Return the session of the person of a role; it may be over."""
        return self._tokens.get(role, "")

    def is_logged_in(self, role: Role) -> bool:
        """Return whether the session that a role had is still one."""
        try:
            return self.logins.find(self.session(role), ADDRESS).role is role
        except PermissionError:
            return False

    def person(self, role: Role) -> Person:
        return self.logins.find(self.session(role), ADDRESS)

    def ask(self, method: str, path: str, role: Role, values: Any = None, **more: Any) -> Reply:
        """Ask as the browser of a person of a role."""
        return self.site.ask(method, path, values, self.session(role), **more)

    def exchange(self, sent: bytes, ends: bool = False) -> bytes:
        """Send bytes; return all that comes back until the server closes the connection.

        Args:
            sent: Requests.
            ends: Whether the server learns that no more bytes come: it waits for them else.
        """
        address = ("127.0.0.1", self.site.port)
        with socket.create_connection(address, LIMIT_S) as connection:
            try:
                connection.sendall(sent)
                if ends:
                    connection.shutdown(socket.SHUT_WR)
                return b"".join(iter(lambda: connection.recv(65536), b""))
            except ConnectionError:
                return b""

    def forget(self) -> None:
        kept = (self.control.asked, self.surveys.services.asked, self.storage.asked)
        for one in (*kept, self.requests.asked, self.requests.cancelled):
            one.clear()

    def done(self) -> Tuple[Any, ...]:
        """Return everything that a request can change."""
        files = (self.folder / "web" / "accounts.txt", *self.surveys.data.rglob("*"))
        return (
            tuple(map(repr, self.control.asked)),
            tuple(map(repr, self.surveys.services.asked)),
            (len(self.storage.asked), len(self.requests.asked), len(self.requests.cancelled)),
            self.lease.holder,
            tuple((str(one), one.stat().st_size, one.stat().st_mtime_ns) for one in files),
            tuple(self.is_logged_in(role) for role in PEOPLE),
        )


def is_without_right(reply: Reply) -> bool:
    """Return whether a request was refused because of who has sent it."""
    if reply.status not in (401, 403):
        return False
    return reply.values.get("code") in (NOT_LOGGED_IN.code, NOT_ALLOWED.code)


NOBODY, WATCH, CONTROL = Role
PRESS = {"press": "0" * 32}
# What the path of a request has for {folder}: a stored survey.
S = "/api/surveys/{folder}"


class Row(NamedTuple):
    """A route, who may use it, and a request that the page sends."""

    method: str
    path: str
    right: Role
    values: Mapping[str, Any] = {}


TABLE = (
    # Before the login there is the form alone.
    Row("GET", "/api/me", NOBODY),
    Row("POST", "/api/login", NOBODY, {"name": "vera", "password": PASSWORD}),
    # Everybody with an account watches.
    Row("GET", "/api/live", WATCH),
    Row("POST", "/api/logout", WATCH),
    Row("GET", "/api/ground", WATCH),
    Row("GET", "/api/ground/map.png", WATCH),
    Row("GET", "/api/ground/section.png", WATCH),
    Row("GET", "/api/ground/bar.png", WATCH),
    Row("GET", "/api/service", WATCH),
    # The stored surveys: search, verdict, candidates, downloads.
    Row("GET", "/api/surveys", WATCH),
    Row("GET", S, WATCH),
    Row("POST", f"{S}/candidates", WATCH),
    Row("GET", f"{S}/zip", WATCH),
    Row("GET", f"{S}/made/report-html", WATCH),
    # Notes, markers, found records, PAUSE and STOP from anywhere.
    Row("POST", f"{S}/notes", WATCH, {"text": "wet"}),
    Row("POST", f"{S}/markers", WATCH, {"x_mm": 1.0, "y_mm": 2.0, "text": "can"}),
    Row("POST", f"{S}/found", WATCH, {"what": "mine", "candidate": "c", "list": "l"}),
    Row("POST", "/api/pause", WATCH, PRESS),
    Row("POST", "/api/stop", WATCH, PRESS),
    # START and RESUME, and control over them.
    Row("POST", "/api/start", CONTROL, {**PRESS, "plan": plan_id(PLAN)}),
    Row("POST", "/api/resume", CONTROL, {**PRESS, "survey": SURVEY}),
    Row("POST", "/api/control/take", CONTROL),
    Row("POST", "/api/control/release", CONTROL),
)
