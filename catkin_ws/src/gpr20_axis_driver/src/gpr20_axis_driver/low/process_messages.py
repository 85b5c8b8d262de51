"""What the pulse process says of itself."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Ready:
    """It waits for motions.

    Attributes:
        sentence: How it is scheduled, for people.
        realtime: Whether it runs with real-time scheduling.
    """

    sentence: str
    realtime: bool


@dataclass(frozen=True)
class Failure:
    """It ends because of an error; the pins are low."""

    message: str
