"""How far a long work has come, for whoever wants to show it."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Optional, TypeVar

Item = TypeVar("Item")
Progress = Callable[[Iterable[Item], Optional[int]], Iterable[Item]]
"""Takes an iterable and its length, and shows how far its user has come."""


def silent(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
    """Show no progress."""
    return items
