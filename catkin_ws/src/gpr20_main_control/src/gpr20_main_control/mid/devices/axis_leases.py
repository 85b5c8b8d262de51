"""The leases of the axes: while the main control has them, nobody else moves the robot."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Dict, Iterable, List, Mapping, Optional, Protocol

from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.waits import Attention
from gpr20_survey.axes.axis_id import AxisId

# A lease is renewed this many times within its limit.
RENEWALS = 4


@dataclass(frozen=True)
class Lease:
    """A lease of one axis.

    Attributes:
        number: Its number.
        limit_s: It ends when it is not renewed for this long [s].
    """

    number: int
    limit_s: float


class LeasedAxis(Protocol):
    """What an axis needs to be reserved. Every call returns or raises within a time limit."""

    def reserve(self) -> Lease:
        """Reserve the axis.

        Raises:
            NodeLostError: No answer came.
            DeviceError: Another node has it.
        """

    def renew(self, lease: Lease) -> bool:
        """Renew a lease; return whether it still exists.

        Raises:
            NodeLostError: No answer came.
        """

    def release_lease(self, lease: Lease) -> None:
        """End a lease, if the axis answers."""


class _Keeper:
    """Has and renews the lease of one axis."""

    def __init__(self, axis: LeasedAxis, attention: Attention) -> None:
        self._axis = axis
        self._attention = attention
        self._lock = threading.Lock()
        self._lease: Optional[Lease] = None
        self._ended = threading.Event()

    @property
    def held(self) -> bool:
        return self._lease is not None

    def reserve(self) -> None:
        with self._lock:
            if self._lease is not None:
                return
            self._lease = self._axis.reserve()
            self._ended = threading.Event()
            arguments = (self._lease, self._ended)
        threading.Thread(target=self._keep, args=arguments, daemon=True).start()

    def release(self) -> None:
        with self._lock:
            self._ended.set()
            lease, self._lease = self._lease, None
        if lease is not None:
            threading.Thread(target=self._axis.release_lease, args=(lease,), daemon=True).start()

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
        with self._lock:
            if self._lease is lease:
                self._lease = None


class AxisLeases:
    """Reserves all axes for what the main control does with them."""

    def __init__(self, axes: Mapping[AxisId, LeasedAxis], attention: Attention) -> None:
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
                if not keeper.held:
                    keeper.reserve()
            except NodeLostError:
                if axis_id in wanted:
                    raise

    def release(self) -> None:
        """Release every axis; returns at once."""
        for keeper in self._keepers.values():
            keeper.release()
