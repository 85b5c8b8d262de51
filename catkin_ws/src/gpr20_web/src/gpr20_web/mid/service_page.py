"""SERVICE: what is wrong with the robot, as ROBOT of the window says it. Nothing moves here."""

from __future__ import annotations

from typing import Any, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import summary
from gpr20_operator.jobs.job import Service, Ticket
from gpr20_operator.robot.service_model import Examine, ServiceModel
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web.calls import Call, Role, Route, WebPage, sentence

# Who looks asks again within this time [s].
INTEREST_S = 10.0


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

    def refresh(self, snapshot: Snapshot) -> None:
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
