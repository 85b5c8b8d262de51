"""The result of a stored survey, made as in the window, for callers that wait."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from typing import Any, Callable, Optional, Protocol, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_operator.jobs.job import Service, Ticket
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
        ended: Whether the search has ended.
    """

    def __init__(self, services: SurveyServices, folder: str) -> None:
        self._services = services
        self.folder, self.began_s = folder, time.monotonic()
        self.stored: Optional[StoredSurvey] = None
        self.image: Optional[FocusedImage] = None
        self.searching, self.ended = "", False
        self.result = SurveyResult(Imaging(self, time.monotonic))
        self.result.open(folder)
        self.result.keep()

    @property
    def made_of(self) -> Tuple[object, ...]:
        """What an image of it depends on."""
        record = self.result.record
        return () if record is None else (record.stored, self.result.permittivity)

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


class CandidateSearches:
    """Reads surveys, and searches one at a time; may be used by any thread.

    Args:
        services: Storage and imaging node.
        in_background: Calls something in a thread of its own.

    Attributes:
        last: The last survey that was searched; None: none was.
    """

    def __init__(
        self, services: SurveyServices, in_background: Callable[[Callable[[], None]], None]
    ) -> None:
        self._services, self._in_background = services, in_background
        self._lock = threading.Lock()
        self._known: OrderedDict[str, OpenedSurvey] = OrderedDict()
        self.last: Optional[OpenedSurvey] = None

    def read(self, folder: str) -> OpenedSurvey:
        """Return a survey, with its candidates if they are known."""
        opened, known = OpenedSurvey(self._services, folder), self._known.get(folder)
        # Not after it was resumed, or somebody has entered another permittivity.
        if known is not None and known.made_of == opened.made_of:
            opened.image = known.result.image
            opened.result.keep()
        return opened

    def begin(self, folder: str) -> None:
        """Search a survey, unless it is being searched.

        Raises:
            BusyError: Another one is being searched.
        """
        opened = OpenedSurvey(self._services, folder)
        with self._lock:
            if self.last is not None and not self.last.ended:
                if self.last.folder == folder:
                    return
                raise BusyError(Message("another survey is being searched for candidates"))
            self.last = opened
        self._in_background(lambda: self._search(opened))

    def end(self) -> None:
        """End the search that runs."""
        if self.last is not None and not self.last.ended:
            self._services.cancel(self.last.searching)

    def _search(self, opened: OpenedSurvey) -> None:
        try:
            opened.result.keep()
            if opened.result.image is not None:
                with self._lock:
                    self._known[opened.folder] = opened
                    self._known.move_to_end(opened.folder)
                    while len(self._known) > MOST_KNOWN:
                        self._known.popitem(last=False)
        finally:
            # The next one can begin whatever has happened.
            opened.ended = True
