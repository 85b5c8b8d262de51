"""The four commands of the page, and who may give them when. There are no others."""

from __future__ import annotations

import hashlib
import json
import uuid
from dataclasses import asdict
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.plan.form import preview
from gpr20_operator.plan.texts import HANDS_CLEAR, plan_rows, spacing_warning
from gpr20_operator.robot.events import Answer, Request, StartPlan, SurveyControl
from gpr20_operator.robot.notices import MOTORS_OFF, StopConfirmation
from gpr20_operator.robot.remote_control import RemoteAllowance
from gpr20_operator.robot.snapshot import Snapshot, SurveyModel, survey_name
from gpr20_web.calls import Call, Role, Route, Text, WebPage, sentence
from gpr20_web.faults import NOT_ARMED, BadRequestError, NotAllowedError, NotNowError
from gpr20_web.mid.presses import Lease, Presses, log_entry, press_of

# Of ground of which nothing is known.
AIR = 1.0
NOT_POSSIBLE = Message("this is not possible in the present state")


class Commands(WebPage):
    """STOP, PAUSE, START, RESUME and the control over them.

    Args:
        model: Shows what was asked for.
        control: Asks the robot.
        allowance: Whether somebody at the robot allows START and RESUME, and of which plan.
        lease: Who may start and resume.
        note: Adds values to the log of a survey, by its id; it does not wait.
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

    def __init__(
        self,
        model: SurveyModel,
        control: SurveyControl,
        allowance: RemoteAllowance,
        clock: Clock,
        lease: Lease,
        note: Callable[[str, Mapping[str, Any]], None],
    ) -> None:
        self._model, self._control, self._allowance = model, control, allowance
        self._clock, self._lease, self._note = clock, lease, note
        self._snapshot: Optional[Snapshot] = None
        self._presses = Presses()
        # Who has started a survey that the storage has not opened yet, by its id.
        self._starts: Dict[str, Call] = {}
        self._described = ""
        self._stop = StopConfirmation(clock)
        self._warning: Optional[Message] = None
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
        self._allowance.on_event(event)
        if isinstance(event, Answer):
            for one in self._presses.end(event):
                self._log(one.call, one.request, f"{one.outcome.value}: {event.message}")
                if event.survey_id:
                    self._starts[event.survey_id] = one.call
        elif isinstance(event, SurveyDescribed):
            self._described = survey_name(event.text)[0]
        # Who has started a survey stands in its own log, once the storage has opened it.
        starter = self._starts.pop(self._described, None)
        if starter is not None:
            self._log(starter, Request.START, "begun", self._described)

    def show_state(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._snapshot = snapshot
        self._allowance.note(snapshot)
        if self._allowance.obstacle is not None:
            self._control.withdraw_start()
        self._lease.refresh(self._allowance.armed)
        self._warning = self._stop.warning(snapshot)
        self._presses.refresh(self._clock.now_s())

    def live(self, text: Text) -> Mapping[str, Any]:
        """Return what may be pressed, what is allowed, and what became of the last command."""
        snapshot, allowance = self._snapshot, self._allowance
        if snapshot is None:
            return {}
        plan = allowance.plan if allowance.armed else None
        until_s = self._clock.now_s() + allowance.remaining_s
        holder, warning = self._lease.holder, self._warning
        return {
            "can": {
                "pause": snapshot.can_pause,
                "resume": snapshot.can_resume and allowance.armed,
                "start": snapshot.can_start and plan is not None,
            },
            "remote": {
                "armed": allowance.armed,
                # By the clock of `sent_ms`; rounded, because it is sent only when it changes.
                "until_ms": round(until_s) * 1000 if allowance.armed else None,
                "obstacle": sentence(text, allowance.obstacle),
                "plan": None if plan is None else _plan_values(plan, text),
            },
            "holder": None if holder is None else {"name": holder.name, "mark": holder.mark},
            "command": self._presses.values(text),
            "stop_open": self._is_stop_open,
            "stop_warning": None
            if warning is None
            else {"title": text(MOTORS_OFF), "text": sentence(text, warning)},
        }

    @property
    def _is_stop_open(self) -> bool:
        return bool(self._presses.waiting(Request.STOP)) or self._stop.is_open

    def _on_stop(self, call: Call) -> Mapping[str, Any]:
        try:
            press = press_of(call)
        except BadRequestError:
            press = uuid.uuid4().hex  # whoever sent it so: it is carried out, and noted
        is_new = press not in self._presses
        # The page asks until it is confirmed; an open one is repeated as long without that.
        if is_new or not self._is_stop_open:
            self._model.request_sent(Request.STOP)
            self._control.stop()
        if is_new:
            self._stop.press()
            self._add(call, Request.STOP, press)
        return {"confirmed": not self._is_stop_open}

    def _pause(self, call: Call) -> Mapping[str, Any]:
        def send(snapshot: Snapshot) -> None:
            _check(snapshot.can_pause)
            self._control.pause_survey()

        return self._once(call, Request.PAUSE, send)

    def _start(self, call: Call) -> Mapping[str, Any]:
        def send(snapshot: Snapshot) -> None:
            self._check_allowed(call, Request.START)
            _check(snapshot.can_start)
            plan = self._allowance.plan
            if plan is None:
                raise NotNowError(Message("the plan at the robot is not complete"))
            if call.values.get("plan") != plan_id(plan):
                raise NotNowError(
                    Message("the plan at the robot was changed; read it again before START")
                )
            self._control.start_survey(plan)

        return self._once(call, Request.START, send)

    def _resume(self, call: Call) -> Mapping[str, Any]:
        def send(snapshot: Snapshot) -> None:
            self._check_allowed(call, Request.RESUME)
            _check(snapshot.can_resume)
            # It is the paused survey that the person has seen, whatever was paused since.
            if call.values.get("survey") != snapshot.running_survey:
                raise NotNowError(Message("another survey is paused now"))
            self._control.resume_survey(snapshot.running_survey)

        return self._once(call, Request.RESUME, send)

    def _take(self, call: Call) -> Mapping[str, Any]:
        self._lease.take(call.who, self._allowance.armed)
        return {}

    def _release(self, call: Call) -> Mapping[str, Any]:
        self._lease.release(call.who)
        return {}

    def _once(
        self, call: Call, request: Request, send: Callable[[Snapshot], None]
    ) -> Mapping[str, Any]:
        """Send a request unless its press is known: an answer may be lost, and asked for again."""
        press = press_of(call)
        if press not in self._presses:
            if self._snapshot is None:
                raise NotNowError(NOT_POSSIBLE)
            send(self._snapshot)
            self._model.request_sent(request)
            self._add(call, request, press)
        return {}

    def _check_allowed(self, call: Call, request: Request) -> None:
        """Check that a person may start and resume now.

        Raises:
            BadRequestError: The request does not say when it was pressed.
            NotNowError: Nobody at the robot allows it, a STOP is open, or it comes too late.
            NotAllowedError: Another page is in control.
        """
        obstacle = self._allowance.obstacle
        try:
            self._presses.check_age(call, self._clock.now_s())
            # A command after STOP would end its repetition, whoever has pressed it.
            if self._is_stop_open:
                raise NotNowError(
                    Message("a STOP is not confirmed yet; if that lasts, press STOP again")
                )
            if obstacle is not None:
                raise NotNowError(obstacle.with_fault(NOT_ARMED))
            self._lease.check(call.who)
        except (NotNowError, NotAllowedError) as error:
            self._log(call, request, f"refused: {error}")
            raise

    def _add(self, call: Call, request: Request, press: str) -> None:
        self._presses.add(press, request, call, self._clock.now_s())
        self._log(call, request, "sent")

    def _log(self, call: Call, request: Request, outcome: str, survey: str = "") -> None:
        """Note who did what in the log of a survey, of the running one if none is given."""
        if not survey and self._snapshot is not None:
            survey = self._snapshot.running_survey
        if survey:
            self._note(survey, log_entry(call, request.value, outcome, self._clock))


def _check(possible: bool) -> None:
    if not possible:
        raise NotNowError(NOT_POSSIBLE)


def plan_id(plan: StartPlan) -> str:
    """Return what only this plan has: a person starts the plan that was read."""
    content = json.dumps(asdict(plan), sort_keys=True, default=str)
    return hashlib.sha256(content.encode()).hexdigest()[:32]


def _plan_values(plan: StartPlan, text: Text) -> Mapping[str, Any]:
    """Return what a person reads of a plan before START."""
    permittivity = plan.permittivity or AIR
    known = preview(plan.parameters, permittivity)
    rows = plan_rows(plan.parameters, permittivity, known, plan.annotation)
    doubt = spacing_warning(known)
    return {
        "id": plan_id(plan),
        "rows": [[text(name), text(value)] for name, value in rows],
        "doubt": "" if doubt is None else text(doubt),
        "warning": text(HANDS_CLEAR),
    }
