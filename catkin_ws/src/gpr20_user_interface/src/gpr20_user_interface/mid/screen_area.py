"""Where a window is put on a screen, so that no part of it is outside."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Area:
    """A rectangle on the screen [pixels]."""

    left: int
    top: int
    width: int
    height: int

    def contains(self, other: Area) -> bool:
        """Whether another rectangle is completely inside this one."""
        return (
            self.left <= other.left
            and self.top <= other.top
            and other.left + other.width <= self.left + self.width
            and other.top + other.height <= self.top + self.height
        )


def fitted(window: Area, frame: Area, free: Area) -> Area:
    """Return the largest place of a framed window that is not larger than it is now.

    Args:
        window: The window without its frame.
        frame: The window with its frame.
        free: The part of the screen that windows may use.

    Returns:
        Left and top of the frame, width and height of the window without it.
    """
    sides, ends = frame.width - window.width, frame.height - window.height
    width = min(window.width, free.width - sides)
    height = min(window.height, free.height - ends)
    left = max(free.left, min(frame.left, free.left + free.width - width - sides))
    top = max(free.top, min(frame.top, free.top + free.height - height - ends))
    return Area(left, top, width, height)
