"""A robot that runs already, and how to end it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Optional, Sequence

from gpr20_common.message import Message
from gpr20_launch.low.process_info import ProcessInfo

TIME_FORMAT = "%Y-%m-%d %H:%M:%S"


@dataclass(frozen=True)
class RunningNode:
    """A node that answers.

    Attributes:
        name: Its full name.
        number: Its process id.
        process: What is known about the process; None if it is on another computer.
        parent: The process that started it; None if that has ended.
    """

    name: str
    number: int
    process: Optional[ProcessInfo]
    parent: Optional[ProcessInfo]

    @property
    def is_left_over(self) -> bool:
        """Whether no roslaunch has started it, or one that has ended."""
        return self.process is not None and not (self.parent and self.parent.is_roslaunch)


def refusal(nodes: Sequence[RunningNode], master: str) -> Message:
    """Return which nodes answer, at least one, since when, and the command that ends them."""
    names = ", ".join(f"{one.name} (process {one.number})" for one in nodes)
    remedy = _remedy(nodes)
    times = [one.process.started for one in nodes if one.process]
    if not times:
        return Message(
            "a robot is running on {master}: {names}. {remedy}",
            master=master,
            names=names,
            remedy=remedy,
        )
    return Message(
        "a robot is running on {master} since {time}: {names}. {remedy}",
        master=master,
        time=min(times).strftime(TIME_FORMAT),
        names=names,
        remedy=remedy,
    )


def _remedy(nodes: Sequence[RunningNode]) -> Message:
    launches: Mapping[int, ProcessInfo] = {
        one.parent.number: one.parent for one in nodes if one.parent and one.parent.is_roslaunch
    }
    left_over = [one.number for one in nodes if one.is_left_over]
    if left_over:
        return Message(
            "No launch that runs has started them. To end them, run this; a survey that runs is "
            "stopped and can be resumed: {command}",
            command="kill " + " ".join(str(number) for number in (*launches, *left_over)),
        )
    if launches:
        return Message(
            "To end it, press Ctrl-C in its terminal, or: {command}. To launch another robot "
            "beside it, add a namespace, such as ns:=robot2",
            command="kill -INT " + " ".join(map(str, launches)),
        )
    return Message(
        "It was started on another computer; end it there. To launch another robot beside it, add "
        "a namespace, such as ns:=robot2"
    )
