"""The time limit of a request, and the messages to one MS2026C over one link after the other."""

from __future__ import annotations

import os
import re
import threading
from contextlib import contextmanager
from typing import Callable, Collection, Dict, Generator, Optional, Protocol, Set, Tuple

from gpr20_common.faults import BUSY
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_vna_acquisition.errors import (
    VnaClosedError,
    VnaDataError,
    VnaError,
    VnaNoAnswerError,
    VnaTimeoutError,
    not_connected,
)
from gpr20_vna_acquisition.mid.block_parser import unquoted

# How often a call that does not return is looked for [s].
WATCH_PERIOD_S = 0.5
# What some instruments answer to a query that they do not know, such as -113 or -400 (SCPI); no
# answer that is wanted begins like this.
ERROR_CODE = re.compile(rb'\s*"?-[0-9]{3}(?![0-9.])')


class RequestDeadline:
    """Limits a request as a whole: an instrument that is slow at every step counts as hanging.

    Nothing can end a call of a library that does not return: `overdue` says that there is one, and
    `end_if_overdue` ends the process.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._closed = False
        # Set when the running request must end before its time limit.
        self._ending = threading.Event()
        self._limit_s = self._extended_s = 0.0
        self._extensible = False
        self._deadline_s = clock.now_s()
        # Name of each call that runs and is watched, when it began and how long it may take [s].
        self._calls: Dict[object, Tuple[str, float, float]] = {}
        self._late: Set[object] = set()

    def begin(self, limit_s: float, waited_s: float = 0.0, extensible: bool = False) -> None:
        """Begin a request that may take `limit_s`; it has already waited `waited_s` of that [s].

        `extend` applies only to one that is `extensible`: the caller of any other knows its limit.
        """
        self._ending.clear()
        self._limit_s = limit_s
        self._deadline_s = self._clock.now_s() + limit_s - waited_s
        self._extensible, self._extended_s = extensible, 0.0

    def extend(self, duration_s: float) -> None:
        """Allow an extensible request so much more time [s]; of several the longest counts."""
        more_s = max(0.0, duration_s - self._extended_s)
        if self._extensible:
            self._extended_s += more_s
            self._limit_s += more_s
            self._deadline_s += more_s

    def close(self) -> None:
        """End the running request at its next step, and every later one at its first."""
        self._closed = True
        self._ending.set()

    def abandon(self) -> None:
        """End the running request at its next step, if there is one."""
        self._ending.set()

    def now_s(self) -> float:
        return self._clock.now_s()

    def check(self) -> None:
        """Raise VnaClosedError or VnaTimeoutError if the request must end."""
        if self._closed:
            raise VnaClosedError(Message("the VNA driver is shutting down"))
        if self._ending.is_set():
            raise VnaTimeoutError(Message("the request was ended by a later one"), fault=BUSY)
        if self._clock.now_s() > self._deadline_s:
            raise VnaTimeoutError(
                Message(
                    "the VNA took longer than {limit_s:.3g} s for a request", limit_s=self._limit_s
                )
            )

    def pause_s(self, duration_s: float) -> None:
        """Wait [s], unless the request must end; raise as `check` does."""
        self._clock.wait_s(self._ending, duration_s)
        self.check()

    @contextmanager
    def watched(self, name: str, limit_s: float) -> Generator[None, None, None]:
        """Watch a call that returns by itself within a time limit [s], if all is well.

        A set-up may make each of its calls until it ends, and may end that much later.
        """
        call = object()
        self._calls[call] = name, self._clock.now_s(), limit_s
        try:
            yield
        finally:
            del self._calls[call]

    def overdue(self) -> Optional[Message]:
        """Return what is wrong if a watched call has not returned in time; None if all have.

        It must be late twice in a row: after a pause of the whole process every call is.
        """
        late = {}
        for call, (name, begun_s, limit_s) in tuple(self._calls.items()):
            if self._extensible:
                begun_s = max(begun_s, self._deadline_s + self._extended_s)
            if self._clock.now_s() > begun_s + limit_s:
                late[call] = name
        still, self._late = self._late.intersection(late), set(late)
        for call in still:
            return Message(
                "the VNA does not answer; check its power and cable",
                details=f"{late[call]} does not return; the process ends",
            )
        return None

    def end_if_overdue(self, report: Callable[[str], object]) -> None:
        """Report a watched call that does not return, and end this process."""
        overdue = self.overdue()
        if overdue is not None:
            report(" ".join((overdue.sentence(), *map(str, overdue.all_details))))
            os._exit(1)


class Transport(Protocol):
    """One link. Every call may raise VnaConnectionError; after that the link is dead."""

    def write(self, command: str) -> None:
        """Send a command that has no answer."""

    def ask_raw(self, query: str, limit_s: Optional[float] = None) -> bytes:
        """Send a query and return its answer, byte for byte.

        `limit_s` is the time limit for the answer [s], if it is not that of the link.

        Raises:
            VnaNoAnswerError: There was no answer in time.
        """

    def clear(self) -> None:
        """Empty the instrument's input and output."""

    def lock(self) -> None:
        """Keep all other links from using the instrument, if it offers that, until this one ends.

        Raises:
            VnaConnectionError: Another link has done so.
        """

    def local(self) -> None:
        """Return the control to the front panel."""

    def close(self) -> None:
        """End the link; never fails."""


class Exchanges:
    """Sends commands and queries to one MS2026C, over one link after the other."""

    def __init__(
        self,
        connector: Callable[[str], Transport],
        deadline: RequestDeadline,
        unanswered: Collection[str],
    ) -> None:
        """Begin without a link.

        Args:
            connector: Opens one to an address.
            deadline: Ends a request that takes too long.
            unanswered: Queries that this instrument is known not to answer.
        """
        self._connector = connector
        self._deadline = deadline
        self._unanswered = unanswered
        self._transport: Optional[Transport] = None

    def open(self, address: str, lock: bool, clear: bool) -> None:
        """Open a link, which may lock out others and begin with empty buffers; close an open one.

        Raises:
            VnaConnectionError: Nothing answers there, or another link has locked it.
        """
        self.close()
        self._deadline.check()
        self._transport = self._connector(address)
        if lock:
            self._transport.lock()
        if clear:
            self._transport.clear()

    def close(self) -> None:
        """End the link; does nothing without one."""
        transport, self._transport = self._transport, None
        if transport is not None:
            transport.close()

    def write(self, command: str) -> None:
        """Send a command that has no answer."""
        self._link().write(command)

    def ask(self, query: str) -> str:
        """Send a query and return its answer as text, without white space or quotes around it."""
        return _text(self.ask_raw(query))

    def ask_raw(self, query: str) -> bytes:
        """Send a query and return its answer, byte for byte."""
        return self._link().ask_raw(query)

    def ask_optional(self, query: str) -> Optional[str]:
        """Return the answer as `ask_optional_raw` does, as text."""
        answer = self.ask_optional_raw(query)
        return None if answer is None else _text(answer)

    def ask_optional_raw(self, query: str) -> Optional[bytes]:
        """Return the answer to a query that the instrument need not know; None if it does not."""
        if query in self._unanswered:
            return None
        try:
            answer = self.ask_raw(query)
        except VnaNoAnswerError as error:
            raise VnaNoAnswerError(_hint(error.message, query)) from error
        if ERROR_CODE.match(answer):
            reason = Message("the VNA answers with an error", details=repr(answer[:40]))
            raise VnaDataError(_hint(reason, query), fault=VNA_SETTINGS)
        return answer

    def release(self, command: str) -> None:
        """Send a last command and return the control to the front panel; no time limit applies."""
        if self._transport is None:
            return
        try:
            self._transport.write(command)
            self._transport.local()
        except VnaError:
            # The link is dead: there is nobody to release.
            self.close()

    def _link(self) -> Transport:
        self._deadline.check()
        if self._transport is None:
            raise not_connected()
        return self._transport


def _text(answer: bytes) -> str:
    # Latin-1 decodes every byte; some answers contain characters beyond ASCII.
    return unquoted(answer.decode("latin-1"))


def _hint(reason: Message, query: str) -> Message:
    return Message(
        "{reason}; if the VNA never answers {query}, name it in unanswered_queries",
        reason=reason,
        query=query,
    )
