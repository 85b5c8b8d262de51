"""The messages to one MS2026C, over one link after the other."""

from __future__ import annotations

import re
from typing import Callable, Collection, Optional, Protocol

from gpr20_common.message import Message
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_vna_acquisition.errors import (
    VnaDataError,
    VnaError,
    VnaNoAnswerError,
    not_connected,
)
from gpr20_vna_acquisition.mid.block_parser import unquoted
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline

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
