"""One entry of the log as a line of text."""

from __future__ import annotations

from dataclasses import dataclass

# The levels of rosgraph_msgs/Log.
LEVELS = {1: "DEBUG", 2: "INFO", 4: "WARN", 8: "ERROR", 16: "FATAL"}


@dataclass(frozen=True)
class LogEntry:
    """What a node said.

    Attributes:
        time_s: When it was said [s since 1970].
        level: One of the levels of rosgraph_msgs/Log.
        node: Name of the node.
        place: Where in its code.
        text: What it said; may have several lines.
    """

    time_s: float
    level: int
    node: str
    place: str
    text: str

    def line(self) -> str:
        """Return the entry as one line; further lines of the text are indented."""
        level = LEVELS.get(self.level, f"level {self.level}")
        text = self.text.rstrip().replace("\n", "\n    ")
        return f"{self.time_s:.6f} {level} {self.node} [{self.place}] {text}"
