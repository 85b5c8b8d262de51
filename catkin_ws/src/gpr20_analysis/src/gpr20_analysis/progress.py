"""Progress of long operations, for callers that show it."""

from __future__ import annotations

from typing import Any, Callable, Iterable, Iterator, Optional, Sequence, Tuple, TypeVar

Item = TypeVar("Item")
Progress = Callable[[Iterable[Item], Optional[int]], Iterable[Item]]
"""Takes an iterable and its length, if known, and shows how much of it was used."""

STEPS_PER_STAGE = 100


def no_progress(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
    """Show no progress."""
    return items


def in_stages(
    items: Sequence[Item], progress: Progress[int]
) -> Iterator[Tuple[Item, Progress[Any]]]:
    """Yield each item with a progress of its own; together they are shown as one.

    Args:
        items: What is done one after another, in about the same time each.
        progress: Shows the progress of all.
    """
    total = STEPS_PER_STAGE * len(items)
    steps = iter(progress(range(total), total))
    shown = 0

    def show(until: int) -> None:
        nonlocal shown
        while shown < until:
            next(steps, None)
            shown += 1

    def stage(begin: int) -> Progress[Any]:
        def used(own: Iterable[Any], count: Optional[int]) -> Iterator[Any]:
            for number, one in enumerate(own, 1):
                yield one
                if count:
                    show(begin + STEPS_PER_STAGE * number // count)

        return used

    for number, item in enumerate(items):
        yield item, stage(STEPS_PER_STAGE * number)
        show(STEPS_PER_STAGE * (number + 1))
    next(steps, None)
