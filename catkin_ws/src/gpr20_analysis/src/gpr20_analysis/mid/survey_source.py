"""Where the traces of a survey come from, whatever the kind of file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    Iterator,
    List,
    Optional,
    Protocol,
    Tuple,
    TypeVar,
)

from gpr20_survey.trace.trace import Trace

Item = TypeVar("Item")
Progress = Callable[[Iterable[Item], Optional[int]], Iterable[Item]]
"""Takes an iterable and its length, and shows how far its user has come."""


Position = Tuple[float, float, float]
"""Rotation [deg], y and x [mm]."""


@dataclass(frozen=True)
class Fault:
    """Something that is damaged, and the sample that is lost by it, if it can be told."""

    text: str
    index: Optional[int] = None
    position: Optional[Position] = None


class SurveySource(Protocol):
    """One recording of a survey."""

    name: str
    """What it is called, for messages."""
    description: Optional[Dict[str, Any]]
    """Content of survey.json, if it comes with the recording."""
    count: int
    """How many traces it seems to hold; 0 if that cannot be told."""
    faults: List[Fault]
    """What is damaged, as far as `traces` has come."""
    notes: List[str]
    """What else should be known."""

    def traces(self) -> Iterator[Trace]:
        """Yield every whole trace; what is damaged is left out and named in `faults`."""


def silent(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
    """Show no progress."""
    return items
