"""Who does heavy work: this process, or whoever can be asked for a part of it.

Work is cut so that a part does the very same operations as the whole does for it, in the same
order; so results do not depend on who works nor on how many.
"""

from __future__ import annotations

from typing import Any, Callable, List, Protocol, Sequence, TypeVar

import numpy as np

Shared = TypeVar("Shared")


class Workers(Protocol):
    """Applies functions to parts of a work."""

    parts: int
    """Into how many parts a work should be cut; 1: it should not."""

    def map(
        self, function: Callable[[Shared, Any], Any], shared: Shared, things: Sequence[Any]
    ) -> List[Any]:
        """Return function(shared, thing) of each thing, in their order.

        Args:
            function: Of a module; it may be called in another process.
            shared: What all calls need, sent once.
            things: What they differ in.
        """


class ThisProcess:
    """No other workers: one part after another, here."""

    parts = 1

    def map(
        self, function: Callable[[Shared, Any], Any], shared: Shared, things: Sequence[Any]
    ) -> List[Any]:
        """Return function(shared, thing) of each thing, in their order."""
        return [function(shared, thing) for thing in things]


THIS_PROCESS = ThisProcess()


def slices(count: int, parts: int) -> List[slice]:
    """Return slices that cut so many things into parts of about equal size, none empty."""
    edges = np.linspace(0, count, min(parts, count) + 1).astype(int)
    return [slice(int(first), int(after)) for first, after in zip(edges[:-1], edges[1:])]
