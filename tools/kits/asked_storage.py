"""In place of the storage, for what shows surveys: it answers when a test says."""

from __future__ import annotations

from typing import Any, Dict, List, Tuple

from gpr20_common.message import Message
from gpr20_operator.jobs.job import Service, Ticket
from gpr20_operator.jobs.pictures import StoredSurvey, SurveysListed, TracesRead

NAMES = {Service.LIST: "list", Service.READ: "survey", Service.TRACES: "traces"}
ANSWERS = {SurveysListed: "list", StoredSurvey: "survey", TracesRead: "traces"}


class Storage:
    """Remembers what it was asked."""

    def __init__(self) -> None:
        self.asked: List[Tuple[Any, ...]] = []
        self._tickets: Dict[str, Ticket[Any]] = {}

    def of(self, kind: str) -> List[Tuple[Any, ...]]:
        """Return what was asked of a kind."""
        return [one[1:] for one in self.asked if one[0] == kind]

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        fields.pop("max_surveys", None)
        self._tickets[NAMES[service]] = ticket
        self.asked.append((NAMES[service], *fields.values()))

    def answer(self, found: Any) -> None:
        """Answer the last question of that kind."""
        self._tickets[ANSWERS[type(found)]].done(found)

    def fail(self, kind: str, reason: Message) -> None:
        """Refuse the last question of a kind."""
        self._tickets[kind].fail(reason)

    def cancel(self, _request_id: str) -> None:
        """Do nothing: nothing that is asked here can be ended."""
