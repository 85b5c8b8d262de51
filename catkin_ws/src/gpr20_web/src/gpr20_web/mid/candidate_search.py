"""The result of a stored survey, made as in the window, for callers that wait."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any, Callable, Dict, NamedTuple, Optional, Protocol

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_operator.jobs.job import JobState, Service, Ticket
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey
from gpr20_operator.jobs.result import SurveyResult
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_web.errors import BusyError

# Images are large.
MOST_KNOWN = 4


class SurveyServices(Protocol):
    """Storage and imaging node."""

    def ask(self, service: Service, **fields: Any) -> Any:
        """Return what a service answers; raises Gpr20Error."""

    def cancel(self, request_id: str) -> None:
        """Ask to end a request, without waiting."""


class OpenedSurvey:
    """A survey that was read; its jobs are answered at once.

    Attributes:
        result: As in the window; what is lacking has its reason in its jobs.
        stored: What the storage has; None: it cannot be read.
        image: What a search finds without being made; None: it is made.
        searching: The request that searches; empty: none.
    """

    def __init__(self, services: SurveyServices, folder: str) -> None:
        self._services = services
        self.stored: Optional[StoredSurvey] = None
        self.image: Optional[FocusedImage] = None
        self.searching = ""
        self.result = SurveyResult(Imaging(self, time.monotonic))
        self.result.open(folder)
        self.result.keep()

    def ask(self, service: Service, ticket: Ticket[Any], **fields: Any) -> None:
        """Call a service, and let the ticket take the answer."""
        found: Any = self.image
        try:
            if service is Service.FOCUS and found is None:
                self.searching = fields["request_id"] = ticket.request_id
            if service is not Service.FOCUS or found is None:
                found = self._services.ask(service, **fields)
        except Gpr20Error as error:
            ticket.fail(error.message)
            return
        if service is Service.READ:
            self.stored = found
        ticket.done(found)

    def cancel(self, request_id: str) -> None:
        """Ask to end a request."""
        self._services.cancel(request_id)


class _Known(NamedTuple):
    """An image, and what it was made of."""

    image: FocusedImage
    stored: int
    permittivity: Optional[float]


@dataclass
class Search:
    """A search for the candidates of a survey, by its folder."""

    folder: str
    began_s: float
    state: JobState = JobState.RUNNING
    problem: Optional[Message] = None
    opened: Optional[OpenedSurvey] = None


class CandidateSearches:
    """Reads surveys, and searches one at a time; may be used by any thread.

    Args:
        services: Storage and imaging node.
        in_background: Calls something in a thread of its own.

    Attributes:
        last: The last search; None: there was none.
    """

    def __init__(
        self, services: SurveyServices, in_background: Callable[[Callable[[], None]], None]
    ) -> None:
        self._services, self._in_background = services, in_background
        self._lock = threading.Lock()
        self._known: Dict[str, _Known] = {}
        self.last: Optional[Search] = None

    def read(self, folder: str) -> OpenedSurvey:
        """Return a survey, with its candidates if they are known."""
        opened, known = OpenedSurvey(self._services, folder), self._known.get(folder)
        record = opened.result.record
        # Not after it was resumed, or somebody has entered another permittivity.
        made_of = None if record is None else (record.stored, opened.result.permittivity)
        if known is not None and known[1:] == made_of:
            opened.image = known.image
            opened.result.keep()
        return opened

    def begin(self, folder: str) -> None:
        """Search a survey, unless it is being searched.

        Raises:
            BusyError: Another one is being searched.
        """
        with self._lock:
            last = self.last
            if last is not None and last.state is JobState.RUNNING:
                if last.folder == folder:
                    return
                raise BusyError(Message("another survey is being searched for candidates"))
            search = self.last = Search(folder, time.monotonic())
        self._in_background(lambda: self._run(search))

    def end(self) -> None:
        """End the search that runs."""
        last = self.last
        if last is not None and last.state is JobState.RUNNING and last.opened is not None:
            self._services.cancel(last.opened.searching)

    def _run(self, search: Search) -> None:
        state = JobState.FAILED
        try:
            search.opened = opened = OpenedSurvey(self._services, search.folder)
            opened.result.keep()
            image, record = opened.result.image, opened.result.record
            search.problem = opened.result.search.problem or opened.result.reading.problem
            if image is not None and record is not None:
                with self._lock:
                    self._known.pop(search.folder, None)
                    known = _Known(image, record.stored, opened.result.permittivity)
                    self._known[search.folder] = known
                    while len(self._known) > MOST_KNOWN:
                        del self._known[next(iter(self._known))]
                state = JobState.DONE
        finally:
            # The next one can begin whatever has happened.
            search.opened, search.state = None, state
