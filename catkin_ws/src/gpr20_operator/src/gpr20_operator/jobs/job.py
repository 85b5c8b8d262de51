"""What takes a while: it is asked for, reports its progress, can be cancelled, and answers once."""

from __future__ import annotations

import enum
import uuid
from dataclasses import dataclass
from typing import Any, Callable, Generic, Optional, Protocol, TypeVar

from gpr20_common.message import Message

Result = TypeVar("Result")


class Service(enum.Enum):
    """What a job asks of a node; the fields are those of the services.

    A survey is given by its id or the name of its folder.
    """

    FOCUS = "focus_survey"
    """The answer is a FocusedImage, with the candidates in it."""
    HIDE = "map_hidden"
    """The answer is a HidingMap."""
    EXPORT = "export_survey"
    """The answer is an Exported."""
    STICKS = "list_volumes"
    READ = "read_survey"
    """The answer is a StoredSurvey."""
    LIST = "list_surveys"
    """The answer is a SurveysListed: those older than `before`, the newest first."""
    TRACES = "read_traces"
    """The answer is a TracesRead: those at some places in the plan."""
    FACT = "add_fact"
    """Adds a fact, by its `kind` and its `values`; the answer is a Message, as of those below."""
    MOVE = "service_move"
    DAILY = "daily_check"
    HEIGHT = "get_height"
    """The answer is a HeightTested, also when there is no height."""
    ANALYZER = "test_analyzer"
    """The answer is an AnalyzerTest, also of one that failed."""

    @property
    def can_be_cancelled(self) -> bool:
        """Whether it takes so long that it can be ended."""
        return self in (Service.FOCUS, Service.HIDE, Service.EXPORT)


class JobState(enum.Enum):
    """What a job does."""

    READY = "ready"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True)
class Delivery:
    """An answer on its way from the thread of a client into the one of its job."""

    deliver: Callable[[], None]


class Ticket(Generic[Result]):
    """One request of a job; answers count while it is the last one, and not cancelled."""

    def __init__(self, job: Job[Result]) -> None:
        self.request_id = uuid.uuid4().hex
        self._job = job

    def progress(self, stage: Message) -> None:
        """Say what is being done."""
        self._job.take(self, JobState.RUNNING, stage=stage)

    def done(self, result: Result) -> None:
        """Answer."""
        self._job.take(self, JobState.DONE, result=result)

    def fail(self, problem: Message) -> None:
        """Say why there is no answer."""
        self._job.take(self, JobState.FAILED, problem=problem)


class Requests(Protocol):
    """Asks without waiting; tickets take the answers."""

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Call a service."""

    def cancel(self, request_id: str) -> None:
        """Ask to end a request of a ticket."""


class Job(Generic[Result]):
    """One request at a time. Belongs to one thread.

    Args:
        requests: Takes a request without waiting; its ticket takes the answer.
        service: What is asked for.
        now_s: A clock that never goes back [s].
        done: Called with each result.
        failed: Called with the reason why there is none.

    Attributes:
        stage: What is being done; None: it is not known, or nothing is.
        problem: Why there is no result; None: there is no problem.
        result: The last result; None unless the job is done.
        revision: Changes with everything above, the last time at `changed_s`.
    """

    def __init__(
        self,
        requests: Requests,
        service: Service,
        now_s: Callable[[], float],
        done: Callable[[Result], None] = lambda _result: None,
        failed: Callable[[Message], None] = lambda _problem: None,
    ) -> None:
        self._requests, self._service = requests, service
        self._now_s, self._done, self._failed = now_s, done, failed
        self._ticket: Optional[Ticket[Result]] = None
        self.revision = 0
        self._set(JobState.READY)

    @property
    def running(self) -> bool:
        """Whether an answer is awaited."""
        return self.state is JobState.RUNNING

    @property
    def age_s(self) -> float:
        """How long ago it has changed [s]."""
        return self._now_s() - self.changed_s

    def ask(self, **wanted: Any) -> None:
        """Send a request with these fields; one that runs is ended."""
        self.end()
        self._ticket = Ticket(self)
        self._set(JobState.RUNNING)
        self._requests.ask(self._service, self._ticket, **wanted)

    def end(self, reason: Optional[Message] = None) -> None:
        """End a request that runs, and forget the result; people read the reason."""
        ticket, self._ticket = self._ticket, None
        if ticket is not None:
            self._cancel(ticket)
        self._set(JobState.READY, problem=reason)

    def cancel(self, stage: Message) -> None:
        """Ask to end the request that runs; people read the stage until its answer comes."""
        if self._ticket is not None:
            self._cancel(self._ticket)
            self._set(JobState.RUNNING, stage=stage)

    def _cancel(self, ticket: Ticket[Result]) -> None:
        if self._service.can_be_cancelled:
            self._requests.cancel(ticket.request_id)

    def refuse(self, problem: Message) -> None:
        """Say why the result cannot be used, as if there were none."""
        self._set(JobState.FAILED, problem=problem)

    def take(self, ticket: Ticket[Result], state: JobState, **found: Any) -> None:
        """Take progress or the answer of a request, unless it is not the last one."""
        if ticket is not self._ticket:
            return
        if state is not JobState.RUNNING:
            self._ticket = None
        self._set(state, **found)
        if state is JobState.DONE:
            self._done(found["result"])
        elif state is JobState.FAILED:
            self._failed(found["problem"])

    def _set(
        self,
        state: JobState,
        stage: Optional[Message] = None,
        problem: Optional[Message] = None,
        result: Optional[Result] = None,
    ) -> None:
        self.state, self.stage, self.problem, self.result = state, stage, problem, result
        self.changed_s = self._now_s()
        self.revision += 1
