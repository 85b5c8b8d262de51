"""Maintenance outside a survey: one action at a time, which a stop ends."""

from __future__ import annotations

import threading
from typing import Callable, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.interruption import StopInterruption
from gpr20_main_control.mid.robot import Axis
from gpr20_survey.axes.axis_id import AxisId


class ServiceSlot:
    """Holds the action that is in progress; every method may be called from any thread.

    Attributes:
        interruption: What ends the waits of the action.
    """

    def __init__(
        self,
        axes: Mapping[AxisId, Axis],
        clock: Clock,
        on_change: Callable[[Optional[Message]], None],
    ) -> None:
        """Begin with no action.

        Args:
            axes: Stopped with the action.
            clock: The clock of every wait.
            on_change: Called with what is done when an action begins, and None when it has ended.
        """
        self.interruption = StopInterruption(clock)
        self._axes = axes
        self._on_change = on_change
        self._lock = threading.Lock()
        self._activity: Optional[Message] = None

    @property
    def activity(self) -> Optional[Message]:
        """What is done now; None: nothing."""
        return self._activity

    def claim(self, activity: Message) -> None:
        """Begin an action; `release` ends it.

        Raises:
            RequestRefusedError: Another one is in progress.
        """
        with self._lock:
            self.refuse_while_busy()
            self.interruption.stop.clear()
            self._activity = activity
        self._on_change(activity)

    def release(self) -> None:
        """End the action; the axes are at rest."""
        with self._lock:
            self._activity = None
        self._on_change(None)

    def refuse_while_busy(self) -> None:
        """Return if no action is in progress.

        Raises:
            RequestRefusedError: One is.
        """
        if self._activity is not None:
            raise RequestRefusedError(
                Message(
                    "the robot is in service ({activity}); wait for its end, or press STOP",
                    activity=self._activity,
                )
            )

    def stop(self) -> bool:
        """Stop the action at once; return whether there was one."""
        # No lock: a stop does not wait. It comes after the last claim or is for nothing.
        if self._activity is None:
            return False
        self.interruption.stop.set()
        for axis in self._axes.values():
            axis.stop()
        return True

    def shut_down(self) -> None:
        """End the action, because the main control ends."""
        self.interruption.shut_down()
        self.stop()
