"""The four commands of the page, and who may give them when. There are no others."""

from __future__ import annotations

import uuid
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_operator.robot.remote_control import RemoteAllowance, RemotePlan
from gpr20_operator.robot.snapshot import Snapshot, survey_name
from gpr20_operator.robot.stop_confirmation import StopConfirmation, StopWarning
from gpr20_operator.robot.survey_control import SurveyControl
from gpr20_operator.robot.survey_model import Refusal, SurveyModel
from gpr20_web import faults
from gpr20_web.calls import Audited, Call, Role, Route
from gpr20_web.errors import BadRequestError, NotAllowedError, NotNowError
from gpr20_web.mid.lease import Lease
from gpr20_web.mid.now_page import notice_values, sentence
from gpr20_web.mid.presses import Presses, press_of
from gpr20_web.mid.remote_plan import plan_id, plan_values
from gpr20_web.mid.web_page import WebPage


@dataclass
class Robot:
    """The robot that is commanded.

    Attributes:
        shown: Shows what was asked for.
        control: Asks it.
        allowance: Whether somebody at the robot allows START and RESUME, and of which plan.
    """

    shown: SurveyModel
    control: SurveyControl
    allowance: RemoteAllowance
    clock: Clock = field(default_factory=Clock)


class Commands(WebPage):
    """STOP, PAUSE, START, RESUME and the control over them.

    Args:
        robot: What is commanded.
        lease: Who may start and resume.
        audit: Notes who did what.
    """

    words: Mapping[str, Message] = {
        "stop": Message("STOP"),
        "not_emergency": Message("not an emergency stop"),
        "pause": Message("PAUSE"),
        "resume": Message("RESUME"),
        "start": Message("START"),
        "control": Message("Control the robot"),
        "take": Message("Take control"),
        "release": Message("Give control up"),
        "nobody": Message("Nobody is in control."),
        "you": Message("You are in control."),
        "other": Message("{name} is in control.", name="{name}"),
        "armed": Message("A person at the robot allows remote control for {time}.", time="{time}"),
        "confirm_start": Message("Start this survey?"),
        "confirm_resume": Message("Resume the survey?"),
        "confirm": Message("Yes"),
        "cancel": Message("No"),
        "sent": Message(
            "{command} was sent. It is not known yet whether it arrived.", command="{command}"
        ),
        "lost": Message(
            "No answer to {command}: it is unknown whether it arrived. The state of the robot "
            "decides.",
            command="{command}",
        ),
        "stop_open": Message(
            "STOP is not confirmed yet: it is unknown whether it arrived. It is sent again until "
            "it is."
        ),
        "stop_alarm": Message("STOP NOT CONFIRMED: use the power switch"),
        "stop_undone": Message("STOP was NOT carried out. It is sent again after a login."),
        "done": Message("{command}: done", command="{command}"),
        "refused": Message("{command}: refused", command="{command}"),
        "unknown": Message("{command}: unknown", command="{command}"),
    }

    def __init__(self, robot: Robot, lease: Lease, audit: Audited) -> None:
        self._robot, self._lease, self._audit = robot, lease, audit
        self._snapshot: Optional[Snapshot] = None
        self._presses = Presses()
        self._refusal: Optional[Refusal] = None
        # Who has started a survey that the storage has not opened yet, by its id.
        self._starts: Dict[str, Call] = {}
        self._described = ""
        self._stop = StopConfirmation(robot.clock)
        self._warning: Optional[StopWarning] = None
        self.routes = (
            Route("POST", "/api/stop", Role.WATCH, self._on_stop),
            Route("POST", "/api/pause", Role.WATCH, self._pause),
            Route("POST", "/api/start", Role.CONTROL, self._start),
            Route("POST", "/api/resume", Role.CONTROL, self._resume),
            Route("POST", "/api/control/take", Role.CONTROL, self._take),
            Route("POST", "/api/control/release", Role.CONTROL, self._release),
        )

    def on_event(self, event: object) -> None:
        """Follow the answers."""
        self._stop.on_event(event)
        self._robot.allowance.on_event(event)
        if isinstance(event, Answer):
            for one in self._presses.end(event):
                said = f"{one.outcome.value}: {event.message}"
                self._audit(one.call, one.request.value, said, self._survey)
                if event.survey_id:
                    self._starts[event.survey_id] = one.call
                    self._note_start()
        elif isinstance(event, SurveyDescribed):
            self._described = survey_name(event.text)[0]
            self._note_start()
        elif isinstance(event, AxisStopAnswer):
            answer = "answered" if event.answered else "did not answer"
            for one in self._presses.stops(event.axis, self._robot.clock.now_s()):
                self._audit(one.call, "stop", f"{event.axis.value} axis {answer}", self._survey)

    def _note_start(self) -> None:
        """Note who has started a survey in its own log, once the storage has opened it."""
        call = self._starts.pop(self._described, None)
        if call is not None:
            self._audit(call, Request.START.value, "begun", self._described)

    def take_refusal(self, refusal: Optional[Refusal]) -> None:
        """Take what failed after it was accepted, as the state shows; None: nothing."""
        if refusal is not None and self._presses.last is not None:
            self._refusal = refusal

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._snapshot = snapshot
        self._robot.allowance.note(snapshot)
        if self._robot.allowance.obstacle is not None:
            self._robot.control.withdraw_start()
        self._lease.refresh(self._robot.allowance.armed)
        self._warning = self._stop.warning(snapshot)
        self._presses.refresh(self._robot.clock.now_s())

    def live(self, text: Callable[[Message], str]) -> Mapping[str, Any]:
        """Return what may be pressed, what is allowed, and what became of the last command."""
        snapshot, allowance = self._snapshot, self._robot.allowance
        if snapshot is None:
            return {}
        plan = allowance.plan if allowance.armed else None
        until_s = self._robot.clock.now_s() + allowance.remaining_s
        warning = self._warning
        return {
            "can": {
                "stop": snapshot.replay is None,
                "pause": snapshot.can_pause,
                "resume": snapshot.can_resume and allowance.armed,
                "start": snapshot.can_start and plan is not None,
            },
            "remote": {
                "armed": allowance.armed,
                # By the clock of `sent_ms`; rounded, because it is sent only when it changes.
                "until_ms": round(until_s) * 1000 if allowance.armed else None,
                "obstacle": sentence(text, allowance.obstacle),
                "plan": None if plan is None else plan_values(plan, text),
            },
            "holder": None
            if self._lease.holder is None
            else {"name": self._lease.holder.name, "mark": self._lease.holder.mark},
            "command": self._presses.values(text),
            "refusal": self._refused(text),
            "stop_open": self._is_stop_open,
            "stop_warning": None
            if warning is None
            else {"title": text(warning.title), "text": sentence(text, warning.text)},
        }

    @property
    def _is_stop_open(self) -> bool:
        return bool(self._presses.waiting(Request.STOP)) or self._stop.is_open

    def _on_stop(self, call: Call) -> Mapping[str, Any]:
        try:
            press = press_of(call)
        except BadRequestError:
            press = uuid.uuid4().hex  # whoever sent it so: it is carried out, and noted
        is_new = self._presses.find(press) is None
        # The page asks until it is confirmed; an open one is repeated as long without that.
        if is_new or not self._is_stop_open:
            self._robot.shown.request_sent(Request.STOP)
            self._robot.control.stop()
        if is_new:
            if self._snapshot is not None:
                self._stop.press(self._snapshot)
            self._note(call, Request.STOP, press)
        return {"confirmed": not self._is_stop_open}

    def _take(self, call: Call) -> Mapping[str, Any]:
        self._lease.take(call.who, self._robot.allowance.armed)
        return {}

    def _release(self, call: Call) -> Mapping[str, Any]:
        self._lease.release(call.who)
        return {}

    def _pause(self, call: Call) -> Mapping[str, Any]:
        def send(snapshot: Snapshot) -> None:
            _check(snapshot.can_pause)
            self._robot.control.pause_survey()

        return self._once(call, Request.PAUSE, send)

    def _start(self, call: Call) -> Mapping[str, Any]:
        def send(snapshot: Snapshot) -> None:
            plan = self._allowed(call)
            _check(snapshot.can_start)
            if plan is None:
                raise NotNowError(Message("the plan at the robot is not complete"))
            if call.values.get("plan") != plan_id(plan):
                raise NotNowError(
                    Message("the plan at the robot was changed; read it again before START")
                )
            self._robot.control.start_survey(
                plan.parameters, plan.annotation, plan.refines, plan.permittivity
            )

        return self._once(call, Request.START, send)

    def _resume(self, call: Call) -> Mapping[str, Any]:
        def send(snapshot: Snapshot) -> None:
            self._allowed(call)
            _check(snapshot.can_resume)
            # It is the paused survey that the person has seen, whatever was paused since.
            if call.values.get("survey") != snapshot.running_survey:
                raise NotNowError(Message("another survey is paused now"))
            self._robot.control.resume_survey(snapshot.running_survey)

        return self._once(call, Request.RESUME, send)

    def _once(
        self, call: Call, request: Request, send: Callable[[Snapshot], None]
    ) -> Mapping[str, Any]:
        """Send a request unless its press is known: an answer may be lost, and asked for again."""
        press = press_of(call)
        if self._presses.find(press) is None:
            _check(self._snapshot is not None)
            if self._snapshot is not None:
                send(self._snapshot)
            self._robot.shown.request_sent(request)
            self._note(call, request, press)
        return {}

    def _allowed(self, call: Call) -> Optional[RemotePlan]:
        """Return the plan that may be started.

        Raises:
            BadRequestError: The request does not say when it was pressed.
            NotNowError: Nobody at the robot allows it, a STOP is open, or it comes too late.
            NotAllowedError: Another page is in control.
        """
        obstacle = self._robot.allowance.obstacle
        try:
            self._presses.check_age(call, self._robot.clock.now_s())
            # A command after STOP would end its repetition, whoever has pressed it.
            if self._is_stop_open:
                raise NotNowError(
                    Message("a STOP is not confirmed yet; if that lasts, press STOP again")
                )
            if obstacle is not None:
                raise NotNowError(obstacle.with_fault(faults.NOT_ARMED))
            self._lease.check(call.who)
        except (NotNowError, NotAllowedError) as error:
            self._audit(call, "refused", str(error), self._survey)
            raise
        return self._robot.allowance.plan

    def _note(self, call: Call, request: Request, press: str) -> None:
        self._presses.add(press, request, call, self._robot.clock.now_s())
        self._refusal = None
        self._audit(call, request.value, "sent", self._survey)

    @property
    def _survey(self) -> str:
        return "" if self._snapshot is None else self._snapshot.running_survey

    def _refused(self, text: Callable[[Message], str]) -> Optional[Mapping[str, Any]]:
        refusal = self._refusal
        if refusal is None or refusal.request is Request.STOP:
            return None
        return notice_values(refusal_notice(Refused[refusal.request.name], refusal.reason), text)


def _check(possible: bool) -> None:
    if not possible:
        raise NotNowError(Message("this is not possible in the present state"))
