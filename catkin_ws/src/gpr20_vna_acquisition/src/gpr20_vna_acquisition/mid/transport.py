"""What the driver needs from a link to the instrument."""

from __future__ import annotations

from typing import Callable, Protocol


class Transport(Protocol):
    """One link. Every call may raise VnaConnectionError; after that the link is dead."""

    def write(self, command: str) -> None:
        """Send a command that has no answer."""

    def ask(self, query: str) -> str:
        """Send a query and return its answer as text without white space around it."""

    def ask_raw(self, query: str) -> bytes:
        """Send a query and return its answer, byte for byte."""

    def clear(self) -> None:
        """Empty the instrument's input and output."""

    def close(self) -> None:
        """End the link; never fails."""


# Opens a link to an address; raises VnaConnectionError.
Connector = Callable[[str], Transport]
