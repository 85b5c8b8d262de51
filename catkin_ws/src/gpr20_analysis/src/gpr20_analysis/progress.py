"""Progress of long operations, for callers that show it."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Optional, TypeVar

Item = TypeVar("Item")
Progress = Callable[[Iterable[Item], Optional[int]], Iterable[Item]]
"""Takes an iterable and its length, if known, and shows how much of it was used."""


def no_progress(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
    """Show no progress."""
    return items
