"""Who may move an axis: one owner at a time."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager
from typing import Callable, Iterator

from gpr20_axis_driver.axis_exceptions import AxisBusyError, LeaseLapsedError
from gpr20_common.message import Message
from gpr20_survey.faults import CONTROL_SILENT


class AxisLease:
    """At most one owner of an axis, by the name of its node; called from any thread.

    A node that reserves the axis has a lease, which ends when it is not renewed in time. While
    nobody has one, a node that moves the axis is its owner until the motion has ended. It guards
    against mistakes, not against attackers: in ROS 1 every node can take any name.
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
        self._check_owner(caller)
        with self._lock:
            if caller == self._holder and not self._is_live():
                raise LeaseLapsedError(self.lapse)

    def _check_owner(self, caller: str) -> None:
        owner = self.owner
        if owner not in ("", caller):
            raise AxisBusyError(
                Message(
                    "the axis belongs to {owner} now; wait until that is done, or press STOP there",
                    owner=owner,
                )
            )

    def reserve(self, caller: str) -> int:
        """Reserve the axis and return the number of the lease; a former lease of its is replaced.

        Raises:
            AxisBusyError: Another node owns it.
        """
        with self._lock:
            self._check_owner(caller)
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
    def use(self, caller: str) -> Iterator[Callable[[], bool]]:
        """Own the axis for one motion.

        Yields:
            A function that returns whether the motion must end, because the lease with which it
            began has ended.

        Raises:
            AxisBusyError: Another node owns it.
            LeaseLapsedError: See `check`.
        """
        with self._lock:
            self.check(caller)
            self._user = caller
            self._uses += 1
            number = self._number if self._is(caller, self._number) else 0
        try:
            yield lambda: number > 0 and not self._is(caller, number)
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
