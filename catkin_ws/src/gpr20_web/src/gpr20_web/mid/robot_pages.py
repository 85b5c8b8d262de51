"""NOW and SERVICE: the state of robot and survey, and what is wrong, as the window says it."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import summary
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.jobs.job import Service, Ticket
from gpr20_operator.robot.condition import JobLevel, condition_of, left_of
from gpr20_operator.robot.events import CurrentPosition
from gpr20_operator.robot.notices import fault_notice
from gpr20_operator.robot.service_model import Examine, ServiceModel
from gpr20_operator.robot.snapshot import (
    Snapshot,
    area_of,
    line_of,
    percent_of,
    progress_of,
    survey_name,
)
from gpr20_web.calls import Call, Role, Route, Text, WebPage, sentence

# Who looks at SERVICE asks again within this time [s].
INTEREST_S = 10.0


def _at(place: CurrentPosition) -> Message:
    return Message("X {x_mm:.1f} mm, Y {y_mm:.1f} mm, {z_deg:.0f} deg", **vars(place))


class NowPage(WebPage):
    """The band, the job and what is wrong.

    Args:
        robot: Its name, where there are several; else empty.
    """

    words: Mapping[str, Message] = {
        "title": Message("Survey"),
        "stored": Message("Stored"),
        "traces": Message("{stored} of {planned} traces", stored="{stored}", planned="{planned}"),
        "survey": Message("Survey"),
        "area": Message("Area"),
        "line": Message("Line"),
        "position": Message("Antennas at"),
        "result": Message("Result"),
        "raw": Message("Echoes, not judged. No echo does not mean no mine."),
        "details": Message("Details"),
        "simulated": Message("SIMULATED"),
    }

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._snapshot: Optional[Snapshot] = None
        self._named: Tuple[str, str] = ("", "")

    def on_event(self, event: object) -> None:
        """Follow the name of the survey."""
        if isinstance(event, SurveyDescribed):
            self._named = survey_name(event.text)

    def show_state(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._snapshot = snapshot

    def live(self, text: Text) -> Mapping[str, Any]:
        """Return band, job and fault."""
        snapshot = self._snapshot
        if snapshot is None:
            return {}
        band, state, fault = self._band(snapshot, text), snapshot.state, None
        if state is not None and state.is_fault:
            card = fault_notice(state)
            fault = {
                **{"title": text(card.title), "details": list(card.details)},
                **{"text": sentence(text, card.text), "first": sentence(text, card.first)},
                "then": sentence(text, card.then),
            }
        return {
            "robot": {
                "name": self._robot,
                "level": band["level"],
                "simulated": snapshot.simulated,
            },
            "band": band,
            "job": self._job(snapshot, text),
            "fault": fault,
        }

    @staticmethod
    def _band(snapshot: Snapshot, text: Text) -> Mapping[str, Any]:
        condition, left = condition_of(snapshot), left_of(snapshot)
        shows_left = condition.level in (JobLevel.WORKING, JobLevel.PAUSED)
        return {
            "level": condition.level.value,
            "title": text(condition.title),
            "message": sentence(text, condition.message),
            "asked": sentence(text, condition.asked),
            "left": sentence(text, left if shows_left else None),
        }

    def _job(self, snapshot: Snapshot, text: Text) -> Mapping[str, Any]:
        progress, parameters = progress_of(snapshot), snapshot.job_parameters
        state, place = snapshot.state, snapshot.current
        survey_id, name = self._named
        known = state is not None and state.survey_id == survey_id
        return {
            "running": snapshot.running,
            "paused": snapshot.paused,
            "survey": state.survey_id if state is not None else "",
            "name": name if known else "",
            "percent": percent_of(snapshot),
            "stored": None if progress is None else progress.visited_points,
            "planned": None if progress is None else progress.total_points,
            "line": sentence(text, line_of(snapshot)),
            "area": "" if parameters is None else text(area_of(parameters)),
            "place": None if place is None else text(_at(place)),
        }


class NoRequests:
    """Takes the place of what would test instruments or move axes: a page at a distance cannot."""

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Refuse."""
        ticket.fail(Message("{service} is not possible from here", service=service.value))

    def cancel(self, request_id: str) -> None:
        """End nothing: nothing was begun."""


class ServicePage(WebPage):
    """Findings while somebody looks.

    Args:
        examine: As for `ServiceModel`.
    """

    words: Mapping[str, Message] = {
        "title": Message("Service"),
        "waiting": Message("The checks have not ended yet."),
        "all": Message("All checks"),
    }

    def __init__(self, examine: Examine, clock: Clock) -> None:
        self._model = ServiceModel(NoRequests(), examine, clock)
        self._now_s = clock.now_s
        # When somebody asked last; None: nobody looks.
        self._asked_s: Optional[float] = None
        self.routes = (Route("GET", "/api/service", Role.WATCH, self._list),)

    def on_event(self, event: object) -> None:
        """Follow endstops, clocks and limits."""
        self._model.on_event(event)

    def show_state(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._model.refresh(snapshot)
        if self._asked_s is not None and self._now_s() - self._asked_s > INTEREST_S:
            self._asked_s = None
            self._model.set_watched(False)

    def _list(self, call: Call) -> Mapping[str, Any]:
        if self._asked_s is None:
            self._model.set_watched(True)
        self._asked_s = self._now_s()
        found = self._model.findings()
        return {
            "summary": call.text(summary(found)) if found else "",
            "findings": [_finding(one, call) for one in found],
        }


def _finding(one: Finding, call: Call) -> Mapping[str, Any]:
    return {
        "level": one.level.name.lower(),
        "title": call.text(one.level.title),
        "text": sentence(call.text, one.text),
        "remedy": sentence(call.text, one.remedy),
        "wrong": one.level >= Level.UNKNOWN,
    }
