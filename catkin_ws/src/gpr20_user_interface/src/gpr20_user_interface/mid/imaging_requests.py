"""What the window asks of the imaging node."""

from __future__ import annotations

import uuid
from typing import Protocol, Sequence


class CancelRequests(Protocol):
    """Ends requests."""

    def cancel(self, request_id: str) -> None:
        """Ask to end a request."""


class SearchRequests(CancelRequests, Protocol):
    """Searches for candidates, without waiting; the answers come as events."""

    def find_candidates(
        self, request_id: str, survey: str, permittivity: float, language: str
    ) -> None:
        """Ask for the candidates of a survey, by its id or folder; permittivity 0: not known."""

    def map_hidden(self, request_id: str, survey: str, permittivity: float, target: str) -> None:
        """Ask where a target could hide in a survey; permittivity 0: not known."""


class ExportRequests(CancelRequests, Protocol):
    """Exports to sticks, without waiting; the answers come as events."""

    def export(
        self,
        request_id: str,
        survey: str,
        kinds: Sequence[str],
        permittivity: float,
        language: str,
        volume: str,
    ) -> None:
        """Ask to write parts of a survey to the stick that is mounted at a path."""

    def list_volumes(self) -> None:
        """Ask for the sticks."""


class FocusRequests(Protocol):
    """Focuses images, without waiting; the answers come as events."""

    def focus(self, survey_id: str, permittivity: float) -> None:
        """Ask for the focused image of a survey; permittivity 0: not known."""


class ImagingRequests(SearchRequests, ExportRequests, FocusRequests, Protocol):
    """Every request to the imaging node."""


def new_request_id() -> str:
    """Return a name for a request that no other has."""
    return uuid.uuid4().hex
