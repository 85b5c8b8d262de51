"""Who may move an axis: one owner at a time."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager
from typing import Callable, Iterator, Optional

from gpr20_axis_driver.faults import AxisBusyError, LeaseLapsedError
from gpr20_common.message import Message
from gpr20_survey.faults import CONTROL_SILENT

GONE = Message("the axis stopped because the program that moved it is gone").with_fault(
    CONTROL_SILENT
)


class AxisLease:
    """At most one owner of an axis, by the name of its node; called from any thread.

    A node that reserves the axis has a lease, which ends when it is not renewed in time, and its
    motion too. While nobody has one, a node that moves the axis is its owner until the motion has
    ended; the motion ends early when that node is gone. It guards against mistakes, not against
    attackers: in ROS 1 every node can take any name.
    """

    def __init__(self, limit_s: float, now_s: Callable[[], float] = time.monotonic) -> None:
        """Begin with no owner.

        Args:
            limit_s: A lease that is not renewed for this long ends [s].
            now_s: Returns the time [s]; nobody sets it.
        """
        self.limit_s = limit_s
        self._now_s = now_s
        self._lock = threading.RLock()
        self._holder = ""
        self._number = 0
        self._renewed_s = 0.0
        self._user = ""
        self._uses = 0

    @property
    def owner(self) -> str:
        """The node that moves the axis or has reserved it; empty: nobody."""
        with self._lock:
            return self._user or (self._holder if self._is_live() else "")

    @property
    def lapse(self) -> Message:
        """Why a motion ended whose lease has ended."""
        return Message(
            "the axis stopped because the main control did not answer for {limit_s:g} s",
            limit_s=self.limit_s,
        ).with_fault(CONTROL_SILENT)

    def check(self, caller: str) -> None:
        """Return if a node may move the axis now.

        Raises:
            AxisBusyError: Another node owns it.
            LeaseLapsedError: Its lease has ended, and it has not reserved the axis again: nothing
                would end its motion if it hung.
        """
        with self._lock:
            owner = self.owner
            if owner not in ("", caller):
                raise AxisBusyError(
                    Message(
                        "the axis belongs to {owner} now; wait until that is done, or press STOP "
                        "there",
                        owner=owner,
                    )
                )
            if caller == self._holder and not self._is_live():
                raise LeaseLapsedError(self.lapse)

    def reserve(self, caller: str) -> int:
        """Reserve the axis and return the number of the lease; a former lease of its is replaced.

        Raises:
            AxisBusyError: Another node owns it.
        """
        with self._lock:
            if caller == self._holder:
                self._holder = ""
            self.check(caller)
            self._number += 1
            self._holder, self._renewed_s = caller, self._now_s()
            return self._number

    def renew(self, caller: str, number: int) -> None:
        """Renew a lease.

        Raises:
            LeaseLapsedError: It has ended.
        """
        with self._lock:
            if not self._is(caller, number):
                raise LeaseLapsedError(self.lapse)
            self._renewed_s = self._now_s()

    def release(self, caller: str, number: int) -> None:
        """End a lease; nothing happens if it has ended."""
        with self._lock:
            if self._is(caller, number):
                self._holder = ""

    @contextmanager
    def use(
        self, caller: str, is_gone: Callable[[], bool] = lambda: False
    ) -> Iterator[Callable[[], Optional[Message]]]:
        """Own the axis for one motion.

        Args:
            caller: The node that requests the motion.
            is_gone: Whether that node is gone; not asked if it has a lease.

        Yields:
            A function that returns why the motion must end: the lease with which it began has
            ended or, without one, the caller is or was gone; None if it need not.

        Raises:
            AxisBusyError: Another node owns it.
            LeaseLapsedError: See `check`.
        """
        with self._lock:
            self.check(caller)
            self._user = caller
            self._uses += 1
            number = self._number if self._is(caller, self._number) else 0
        reason: Optional[Message] = None

        def why_ended() -> Optional[Message]:
            nonlocal reason
            if number > 0 and not self._is(caller, number):
                reason = self.lapse
            elif number == 0 and is_gone():
                reason = GONE
            return reason

        try:
            yield why_ended
        finally:
            with self._lock:
                self._uses -= 1
                if not self._uses:
                    self._user = ""

    def _is(self, caller: str, number: int) -> bool:
        with self._lock:
            return self._is_live() and (caller, number) == (self._holder, self._number)

    def _is_live(self) -> bool:
        return bool(self._holder) and self._now_s() - self._renewed_s <= self.limit_s
