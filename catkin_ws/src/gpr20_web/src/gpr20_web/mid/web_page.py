"""What every page of the browser has on the server's side."""

from __future__ import annotations

from typing import Any, Callable, Mapping

from gpr20_common.message import Message
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web.calls import Routes


class WebPage:
    """One page; all but its blocking routes is called in the thread of the server.

    Attributes:
        routes: What its script asks for.
        words: The sentences of its script by their names, in every language of the catalogue.
    """

    routes: Routes = ()
    words: Mapping[str, Message] = {}

    def on_event(self, event: object) -> None:
        """Take an event of the robot; most are about something else."""

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""

    def live(self, text: Callable[[Message], str]) -> Mapping[str, Any]:
        """Return its part of what every browser is sent as it changes.

        Args:
            text: Translates a message.
        """
        return {}
