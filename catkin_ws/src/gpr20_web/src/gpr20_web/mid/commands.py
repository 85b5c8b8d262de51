"""The four commands of the page, and who may give them when. There are no others."""

from __future__ import annotations

import enum
import hashlib
import json
import math
import re
from collections import OrderedDict
from dataclasses import asdict, dataclass, field
from typing import Any, Callable, Dict, List, Mapping, Optional, Protocol

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.plan.hold_question import HANDS_CLEAR
from gpr20_operator.plan.preview import preview
from gpr20_operator.plan.tiles import plan_rows, spacing_warning
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_operator.robot.remote_control import RemoteAllowance, RemotePlan
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.stop_confirmation import StopConfirmation
from gpr20_operator.robot.survey_control import SurveyControl
from gpr20_operator.robot.survey_model import Refusal
from gpr20_web import faults
from gpr20_web.calls import Call, Person, Route
from gpr20_web.errors import BadRequestError, NotAllowedError, NotNowError
from gpr20_web.mid.controller import Controller
from gpr20_web.mid.now_page import notice_values, sentence
from gpr20_web.mid.web_page import WebPage
from gpr20_web.roles import Role

# The browser makes a new one for each press.
_PRESS_ID = re.compile("[0-9a-f]{32}")
# A press that is sent again within this many others is not carried out again.
KNOWN_PRESSES = 500
# An answer that has not come by then [s] is called unknown; homing may take longer than the rest.
ANSWER_S = {Request.STOP: 5.0, Request.PAUSE: 12.0, Request.START: 1200.0, Request.RESUME: 1200.0}
NOT_NOW = Message("this is not possible in the present state")


class Outcome(enum.Enum):
    """What is known of a command."""

    SENT = "sent"
    DONE = "done"
    REFUSED = "refused"
    UNKNOWN = "unknown"


@dataclass
class Command:
    """A press of a person, and what became of it."""

    press: str
    request: Request
    person: Person
    sent_s: float
    outcome: Outcome = Outcome.SENT
    said: Optional[Message] = None


class Audited(Protocol):
    """Notes who did what; never waits."""

    def __call__(
        self, call: Call, what: str, outcome: str = "", survey: str = "", **values: Any
    ) -> None:
        """Note it, in the survey's log too if one is named."""


class Requested(Protocol):
    """What shows that a request is not answered yet."""

    def request_sent(self, request: Request) -> None:
        """Note that a request was sent to the main control."""


@dataclass
class Robot:
    """The robot that is commanded.

    Attributes:
        shown: Shows what was asked for.
        control: Asks it.
        allowance: Whether somebody at the robot allows START and RESUME, and of which plan.
    """

    shown: Requested
    control: SurveyControl
    allowance: RemoteAllowance
    clock: Clock = field(default_factory=Clock)


class Commands(WebPage):
    """STOP, PAUSE, START, RESUME and the control over them.

    Args:
        view_may_stop: Whether the site lets those stop who may only watch.
    """

    words: Mapping[str, Message] = {
        "stop": Message("STOP"),
        "not_emergency": Message("not an emergency stop"),
        "pause": Message("PAUSE"),
        "resume": Message("RESUME"),
        "start": Message("START"),
        "take": Message("Take control"),
        "ask": Message("Ask {name} for control", name=""),
        "release": Message("Give control up"),
        "pass": Message("Pass control to {name}", name=""),
        "keep": Message("Keep control"),
        "nobody": Message("Nobody is in control."),
        "you": Message("You are in control."),
        "other": Message("{name} is in control.", name=""),
        "asked": Message("{name} asks for control. It passes in {seconds} s.", name="", seconds=""),
        "armed": Message("A person at the robot allows remote control for {time}.", time=""),
        "confirm_start": Message("Start this survey?"),
        "confirm_resume": Message("Resume the survey?"),
        "confirm": Message("Yes"),
        "cancel": Message("No"),
        "sent": Message("{command} was sent. It is not known yet whether it arrived.", command=""),
        "lost": Message(
            "No answer to {command}: it is unknown whether it arrived. The state of the robot "
            "decides.",
            command="",
        ),
        "done": Message("{command}: done", command=""),
        "refused": Message("{command}: refused", command=""),
        "unknown": Message("{command}: unknown", command=""),
    }

    def __init__(
        self, robot: Robot, controller: Controller, audit: Audited, view_may_stop: bool
    ) -> None:
        self._robot, self._controller, self._audit = robot, controller, audit
        self._snapshot: Optional[Snapshot] = None
        self._presses: OrderedDict[str, Command] = OrderedDict()
        self._calls: Dict[str, Call] = {}
        self._last: Optional[Command] = None
        self._refusal: Optional[Refusal] = None
        self._stop = StopConfirmation(robot.clock)
        self.routes = (
            Route("POST", "/api/stop", Role.VIEW if view_may_stop else Role.OPERATE, self._on_stop),
            Route("POST", "/api/pause", Role.VIEW, self._pause),
            Route("POST", "/api/start", Role.OPERATE, self._start),
            Route("POST", "/api/resume", Role.OPERATE, self._resume),
            Route("POST", "/api/control/take", Role.OPERATE, self._take),
            Route("POST", "/api/control/release", Role.OPERATE, self._release),
            Route("POST", "/api/control/pass", Role.OPERATE, self._pass),
            Route("POST", "/api/control/keep", Role.OPERATE, self._keep),
        )

    @property
    def controller(self) -> str:
        """The name of the person in control; empty: nobody."""
        holder = self._controller.holder
        return "" if holder is None else holder.name

    def on_event(self, event: object) -> None:
        """Follow the answers."""
        self._stop.on_event(event)
        self._robot.allowance.on_event(event)
        if isinstance(event, Answer):
            self._end(event.request, Outcome.DONE if event.success else Outcome.REFUSED, event)
        elif isinstance(event, AxisStopAnswer) and self._last is not None:
            for call in self._calls_of(Request.STOP):
                answer = "answered" if event.answered else "did not answer"
                self._audit(call, "stop", f"{event.axis.value} axis {answer}", self._survey())

    def take_refusal(self, refusal: Optional[Refusal]) -> None:
        """Take what failed after it was accepted, as the state shows; None: nothing."""
        if refusal is not None and self._last is not None:
            self._refusal = refusal

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._snapshot = snapshot
        self._robot.allowance.note(snapshot)
        self._controller.refresh()
        last, now_s = self._last, self._robot.clock.now_s()
        if (
            last is not None
            and last.outcome is Outcome.SENT
            and now_s - last.sent_s > ANSWER_S[last.request]
        ):
            last.outcome = Outcome.UNKNOWN

    def live(self, text: Callable[[Message], str]) -> Mapping[str, Any]:
        """Return what may be pressed, who is in control, and what became of the last command."""
        snapshot = self._snapshot
        if snapshot is None:
            return {}
        is_robot = snapshot.replay is None
        allowance = self._robot.allowance
        warning = self._stop.warning(snapshot)
        return {
            "can": {
                "stop": is_robot,
                "pause": snapshot.can_pause,
                "resume": snapshot.can_resume and allowance.armed,
                "start": snapshot.can_start and allowance.armed and allowance.plan is not None,
            },
            "remote": {
                "armed": allowance.armed,
                "until_ms": self._until_ms(allowance.remaining_s),
                "obstacle": sentence(text, allowance.obstacle),
                "plan": self._plan(allowance.plan, text) if allowance.armed else None,
            },
            "control": self._control(),
            "command": None if self._last is None else self._outcome(self._last, text),
            "refusal": self._refused(text),
            "stop_warning": None
            if warning is None
            else {"title": text(warning.title), "text": sentence(text, warning.text)},
        }

    def _on_stop(self, call: Call) -> Mapping[str, Any]:
        # First: nothing that is checked or noted may delay it, and one too many harms nobody.
        self._robot.shown.request_sent(Request.STOP)
        self._robot.control.stop()
        if self._snapshot is not None:
            self._stop.press(self._snapshot)
        return self._note(call, Request.STOP, str(call.values.get("press", ""))[:32])

    def _pause(self, call: Call) -> Mapping[str, Any]:
        press = _press(call)
        if press not in self._presses:
            self._known(self._snapshot is not None and self._snapshot.can_pause)
            self._robot.shown.request_sent(Request.PAUSE)
            self._robot.control.pause_survey()
        return self._note(call, Request.PAUSE, press)

    def _start(self, call: Call) -> Mapping[str, Any]:
        press = _press(call)
        if press not in self._presses:
            plan = self._allowed(call).plan
            self._known(self._snapshot is not None and self._snapshot.can_start)
            if plan is None:
                raise NotNowError(Message("the plan at the robot is not complete"))
            if call.values.get("plan") != plan_id(plan):
                raise NotNowError(
                    Message("the plan at the robot was changed; read it again before START")
                )
            self._robot.shown.request_sent(Request.START)
            self._robot.control.start_survey(
                plan.parameters, plan.annotation, plan.refines, plan.permittivity
            )
        return self._note(call, Request.START, press)

    def _resume(self, call: Call) -> Mapping[str, Any]:
        press = _press(call)
        if press not in self._presses:
            self._allowed(call)
            snapshot = self._snapshot
            self._known(snapshot is not None and snapshot.can_resume)
            # It is the paused survey that the person has seen, whatever was paused since.
            if snapshot is None or call.values.get("survey") != snapshot.running_survey:
                raise NotNowError(Message("another survey is paused now"))
            self._robot.shown.request_sent(Request.RESUME)
            self._robot.control.resume_survey()
        return self._note(call, Request.RESUME, press)

    def _allowed(self, call: Call) -> RemoteAllowance:
        """Return the allowance.

        Raises:
            NotNowError: Nobody at the robot allows it.
            NotAllowedError: Another page is in control.
        """
        allowance = self._robot.allowance
        if not allowance.armed:
            reason = allowance.obstacle or Message("nobody at the robot allows remote control now")
            self._audit(call, "refused", "not armed", self._survey())
            raise NotNowError(reason.with_fault(faults.NOT_ARMED))
        try:
            self._controller.check(call.who)
        except NotAllowedError:
            self._audit(call, "refused", "not in control", self._survey())
            raise
        return allowance

    def _known(self, possible: bool) -> None:
        if not possible:
            raise NotNowError(NOT_NOW)

    def _note(self, call: Call, request: Request, press: str) -> Mapping[str, Any]:
        """Note a command that was sent; a press that is known is only answered."""
        command = self._presses.get(press)
        if command is None or request is Request.STOP:
            command = Command(press, request, call.who, self._robot.clock.now_s())
            self._presses[press] = self._last = command
            self._calls[press] = call
            self._refusal = None
            while len(self._presses) > KNOWN_PRESSES:
                old, _command = self._presses.popitem(last=False)
                self._calls.pop(old, None)
            self._audit(call, request.value, "sent", self._survey())
        return {"outcome": command.outcome.value}

    def _end(self, request: Request, outcome: Outcome, answer: Answer) -> None:
        for command in self._open(request):
            command.outcome, command.said = outcome, answer.message
            if not answer.contact:
                command.outcome = Outcome.UNKNOWN
            call = self._calls.pop(command.press, None)
            if call is not None:
                survey = answer.survey_id or self._survey()
                said = f"{command.outcome.value}: {answer.message}"
                self._audit(call, request.value, said, survey)

    def _open(self, request: Request) -> List[Command]:
        return [
            one
            for one in self._presses.values()
            if one.request is request and one.press in self._calls
        ]

    def _calls_of(self, request: Request) -> List[Call]:
        return [self._calls[one.press] for one in self._open(request)]

    def _survey(self) -> str:
        return "" if self._snapshot is None else self._snapshot.running_survey

    def _take(self, call: Call) -> Mapping[str, Any]:
        self._controller.take(call.who)
        self._audit(call, "control", "taken" if self._controller.has(call.who) else "asked for")
        return {}

    def _release(self, call: Call) -> Mapping[str, Any]:
        self._controller.release(call.who)
        self._audit(call, "control", "given up")
        return {}

    def _pass(self, call: Call) -> Mapping[str, Any]:
        self._controller.answer(call.who, True)
        self._audit(call, "control", "passed")
        return {}

    def _keep(self, call: Call) -> Mapping[str, Any]:
        self._controller.answer(call.who, False)
        self._audit(call, "control", "kept")
        return {}

    def _until_ms(self, remaining_s: float) -> Optional[int]:
        # By the clock of `sent_ms`; rounded, because it is sent only when it changes.
        return round(self._robot.clock.now_s() + remaining_s) * 1000 if remaining_s > 0.0 else None

    def _control(self) -> Mapping[str, Any]:
        holder, asked = self._controller.holder, self._controller.asked
        return {
            "holder": None if holder is None else _browser(holder),
            "asked": None
            if asked is None
            else {
                **_browser(asked.person),
                "passes_s": math.ceil(max(0.0, asked.passes_s - self._robot.clock.now_s())),
            },
        }

    @staticmethod
    def _plan(plan: Optional[RemotePlan], text: Callable[[Message], str]) -> Optional[Any]:
        if plan is None:
            return None
        known = preview(plan.parameters, plan.permittivity or 1.0)
        rows = plan_rows(plan.parameters, plan.permittivity or 1.0, known, plan.annotation)
        return {
            "id": plan_id(plan),
            "rows": [[text(name), text(value)] for name, value in rows],
            "doubt": sentence(text, spacing_warning(known)),
            "warning": text(HANDS_CLEAR),
        }

    @staticmethod
    def _outcome(command: Command, text: Callable[[Message], str]) -> Mapping[str, Any]:
        return {
            "press": command.press,
            "request": command.request.value,
            "name": command.person.name,
            "outcome": command.outcome.value,
            "text": sentence(text, command.said),
        }

    def _refused(self, text: Callable[[Message], str]) -> Optional[Mapping[str, Any]]:
        refusal = self._refusal
        if refusal is None or refusal.request is Request.STOP:
            return None
        return notice_values(refusal_notice(Refused[refusal.request.name], refusal.reason), text)


def _press(call: Call) -> str:
    """Return the mark of a press.

    Raises:
        BadRequestError: It has none.
    """
    press = call.values.get("press")
    if not isinstance(press, str) or not _PRESS_ID.fullmatch(press):
        raise BadRequestError(Message("the request has no mark of its press"))
    return press


def plan_id(plan: RemotePlan) -> str:
    """Return what only this plan has: a person starts the plan that was read."""
    content = json.dumps(asdict(plan), sort_keys=True, default=str)
    return hashlib.sha256(content.encode()).hexdigest()[:32]


def _browser(person: Person) -> Dict[str, Any]:
    return {"name": person.name, "mark": person.mark}
