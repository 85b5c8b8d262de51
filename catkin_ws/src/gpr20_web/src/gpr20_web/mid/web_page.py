"""What every page of the browser has on the server's side."""

from __future__ import annotations

from typing import Any, Callable, Mapping

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_web.calls import Routes

# Who looks asks again within this time [s].
INTEREST_S = 10.0


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


class Interest:
    """Begins to follow when somebody asks, and ends when nobody has asked for a while.

    Args:
        follow: Begins or ends; it does not wait.
    """

    def __init__(self, follow: Callable[[bool], None], clock: Clock) -> None:
        self._follow, self._now_s = follow, clock.now_s
        self._asked_s = 0.0
        self.follows = False

    def ask(self) -> None:
        """Note that somebody looks."""
        self._asked_s = self._now_s()
        self._set(True)

    def refresh(self) -> None:
        """End when nobody looks any more."""
        self._set(self.follows and self._now_s() - self._asked_s <= INTEREST_S)

    def _set(self, follows: bool) -> None:
        if follows is not self.follows:
            self.follows = follows
            self._follow(follows)
