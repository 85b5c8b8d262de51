"""What the window asks of the imaging node."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from typing import Protocol, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_survey.results.candidates import CandidateList
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_survey.results.volume import Volume


@dataclass(frozen=True)
class ImageFocused:
    """An image is ready."""

    image: FocusedImage


@dataclass(frozen=True)
class ImageFailed:
    """An image could not be made.

    Attributes:
        survey_id: Of the survey.
        reason: Why, and what to do.
    """

    survey_id: str
    reason: Message


@dataclass(frozen=True)
class VolumesListed:
    """The sticks that are mounted on the computer of the storage."""

    computer: str
    volumes: Tuple[Volume, ...]


@dataclass(frozen=True)
class VolumesFailed:
    """The sticks cannot be listed."""

    reason: Message


@dataclass(frozen=True)
class CandidatesFound:
    """A search has ended with a list.

    Attributes:
        request_id: As it was sent.
        found: The list.
        remarks: What is missing, damaged or noted, in the language of the request.
    """

    request_id: str
    found: CandidateList
    remarks: str


@dataclass(frozen=True)
class HidingMapped:
    """It is known where a target could hide.

    Attributes:
        request_id: As it was sent.
        found: The map.
    """

    request_id: str
    found: HidingMap


@dataclass(frozen=True)
class ExportDone:
    """Everything is on the stick.

    Attributes:
        request_id: As it was sent.
        files: Names on the stick.
    """

    request_id: str
    files: Tuple[str, ...]


@dataclass(frozen=True)
class RequestFailed:
    """A search or an export has failed.

    Attributes:
        request_id: As it was sent.
        reason: Why, and what to do.
    """

    request_id: str
    reason: Message


@dataclass(frozen=True)
class RequestProgress:
    """What the node does for a request.

    Attributes:
        request_id: As it was sent.
        stage: What it does.
    """

    request_id: str
    stage: Message


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
