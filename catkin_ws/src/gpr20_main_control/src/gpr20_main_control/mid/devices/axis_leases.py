"""The leases of the axes: while the main control has them, nobody else moves the robot."""

from __future__ import annotations

import threading
import time
from typing import Dict, Iterable, List, Mapping, Optional

from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.devices.robot import Axis, Lease
from gpr20_main_control.mid.waits import Attention
from gpr20_survey.axes.axis_id import AxisId

# A lease is renewed this many times within its limit.
RENEWALS = 4


class _Keeper:
    """Has and renews the lease of one axis, in a thread of its own: no axis waits for another."""

    def __init__(self, axis: Axis, attention: Attention) -> None:
        self._axis = axis
        self._attention = attention
        self._lock = threading.Lock()
        # Ends the thread that keeps the present lease; None without one.
        self._ended: Optional[threading.Event] = None

    def reserve(self) -> None:
        with self._lock:
            if self._ended is not None:
                return
            arguments = self._axis.reserve(), threading.Event()
            self._ended = arguments[1]
        threading.Thread(target=self._keep, args=arguments, name="axis lease", daemon=True).start()

    def release(self) -> None:
        with self._lock:
            ended, self._ended = self._ended, None
        if ended is not None:
            ended.set()

    def _keep(self, lease: Lease, ended: threading.Event) -> None:
        renewed_s = time.monotonic()
        while not ended.wait(lease.limit_s / RENEWALS):
            begun_s = time.monotonic()
            if self._attention.lacks:
                continue
            try:
                if not self._axis.renew(lease):
                    break
                renewed_s = begun_s
            except NodeLostError:
                if time.monotonic() - renewed_s > lease.limit_s:
                    break
        else:
            self._axis.release_lease(lease)
        with self._lock:
            if self._ended is ended:
                self._ended = None


class AxisLeases:
    """Reserves all axes for what the main control does with them."""

    def __init__(self, axes: Mapping[AxisId, Axis], attention: Attention) -> None:
        """Reserve nothing yet.

        Args:
            axes: The axes.
            attention: Without it while axes move, no lease is renewed, and the axes stop.
        """
        self._keepers: Dict[AxisId, _Keeper] = {
            axis_id: _Keeper(axis, attention) for axis_id, axis in axes.items()
        }

    def ensure(self, needed: Iterable[AxisId]) -> None:
        """Return when the axes are reserved; a lease that ended is replaced.

        Args:
            needed: The axes that are about to move. Others are reserved if they answer.

        Raises:
            DeviceError: Another node has an axis, whatever is needed.
            NodeLostError: An axis that is needed does not answer.
        """
        wanted: List[AxisId] = list(needed)
        for axis_id, keeper in self._keepers.items():
            try:
                keeper.reserve()
            except NodeLostError:
                if axis_id in wanted:
                    raise

    def release(self) -> None:
        """Release every axis; returns at once."""
        for keeper in self._keepers.values():
            keeper.release()
