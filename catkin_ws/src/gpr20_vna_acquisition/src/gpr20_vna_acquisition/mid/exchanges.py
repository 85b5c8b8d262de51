"""The messages to one MS2026C, over one link after the other."""

from __future__ import annotations

import re
from collections import Counter
from typing import Callable, Optional, Protocol, Set

from gpr20_vna_acquisition.errors import VnaError, VnaNoAnswerError, not_connected
from gpr20_vna_acquisition.mid.block_parser import unquoted
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline

# A query that was left unanswered this often in a row, each time by an instrument that then
# answered `*IDN?` on a new link, is one that the instrument does not know. One that it has answered
# needs more evidence.
UNANSWERED, UNANSWERED_AGAIN = 2, 4
# How long the first answer to a query may take that the instrument need not know [s]. The manual
# allows two seconds after a setting.
FIRST_ANSWER_S = 2.0
# What some instruments answer to a query that they do not know, such as -113 or -400 (SCPI); no
# answer that is wanted begins like this.
ERROR_CODE = re.compile(rb'\s*"?-[0-9]{3}(?![0-9.])')


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
    """Sends commands and queries, and remembers which queries this instrument does not answer."""

    def __init__(self, connector: Callable[[str], Transport], deadline: RequestDeadline) -> None:
        """Begin without a link; `connector` opens one to an address."""
        self._connector = connector
        self._deadline = deadline
        self._transport: Optional[Transport] = None
        self.forget()

    def forget(self) -> None:
        """Forget what was learned: it is another instrument."""
        self._answered: Set[str] = set()
        self._silences: Counter = Counter()

    def open(self, address: str, lock: bool) -> None:
        """Open a link, which may lock out others; an open one is closed.

        Raises:
            VnaConnectionError: Nothing answers there, or another link has locked it.
        """
        self.close()
        self._deadline.check()
        self._transport = self._connector(address)
        if lock:
            self._transport.lock()

    def close(self) -> None:
        """End the link; does nothing without one."""
        transport, self._transport = self._transport, None
        if transport is not None:
            transport.close()

    def clear(self) -> None:
        """Empty the instrument's input and output."""
        self._link().clear()

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

    def ask_detail(self, query: str) -> Optional[str]:
        """Return the answer to a query on which no data depend; one silence is enough for None."""
        if self._silences[query]:
            return None
        return self.ask_optional(query)

    def ask_optional_raw(self, query: str) -> Optional[bytes]:
        """Return the answer to a query that the instrument need not know; None if it does not.

        It may say so by an error code instead of its first answer. Silence is an error until it is
        known that there is never an answer.
        """
        if self.never_answered(query):
            return None
        known = query in self._answered
        try:
            answer = self._link().ask_raw(query, None if known else FIRST_ANSWER_S)
        except VnaNoAnswerError:
            self._silences[query] += 1
            raise
        if not known and ERROR_CODE.match(answer):
            self._silences[query] = UNANSWERED
            return None
        self._answered.add(query)
        self._silences[query] = 0
        return answer

    def never_answered(self, query: str) -> bool:
        """Return whether the instrument is known not to answer a query any more."""
        enough = UNANSWERED_AGAIN if query in self._answered else UNANSWERED
        return self._silences[query] >= enough

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
