"""Faults of the simulated analyzer that can be switched while it works."""

from __future__ import annotations

import enum
import threading
from typing import Dict

from gpr20_simulator.errors import FaultError

MOST_TIMES = 1_000_000
UNTIL_CLEARED = 0


class VnaFault(enum.Enum):
    """What can go wrong, and what a count counts."""

    HANG = "HANG"  # messages that never get any reply on the network
    DROP = "DROP"  # messages at which every connection is closed
    SILENT = "SILENT"  # answers that never come, though the network works
    LATE = "LATE"  # answers that come only after the next message, in front of its own
    TRUNCATE = "TRUNCATE"  # data blocks whose last 9 bytes are missing
    NAN = "NAN"  # data blocks in which some numbers are not numbers
    GARBAGE = "GARBAGE"  # answers that are random bytes
    WRONG_IDENTITY = "WRONG_IDENTITY"  # identities that are those of another instrument
    STALE = "STALE"  # triggers after which the data stay those of the sweep before
    REFUSE_SETTINGS = "REFUSE_SETTINGS"  # settings that are ignored


class FaultBoard:
    """The faults that are on now; every method may be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._left: Dict[VnaFault, int] = {}

    def set(self, name: str, count: int = UNTIL_CLEARED) -> None:
        """Switch a fault on.

        Args:
            name: Name of the fault, in capitals or not.
            count: How many times it strikes; 0: until the faults are cleared.

        Raises:
            FaultError: There is no such fault, or the count is not allowed.
        """
        if not 0 <= count <= MOST_TIMES:
            raise FaultError(f"count is {count}; it must lie between 0 and {MOST_TIMES}")
        fault = next((one for one in VnaFault if one.value == name.upper()), None)
        if fault is None:
            names = ", ".join(one.value for one in VnaFault)
            raise FaultError(f"unknown fault '{name[:40]}'; allowed are NONE, {names}")
        with self._lock:
            self._left[fault] = count

    def clear(self) -> None:
        """Switch every fault off."""
        with self._lock:
            self._left.clear()

    def is_permanent(self, fault: VnaFault) -> bool:
        """Return whether the fault stays until it is cleared."""
        with self._lock:
            return self._left.get(fault) == UNTIL_CLEARED

    def strikes(self, fault: VnaFault) -> bool:
        """Return whether the fault happens now; this counts as one time."""
        with self._lock:
            left = self._left.get(fault)
            if left is None:
                return False
            if left == 1:
                del self._left[fault]
            elif left > 1:
                self._left[fault] = left - 1
            return True

    def names(self) -> str:
        """Return the faults that are on, for people; empty if there is none."""
        with self._lock:
            return ", ".join(sorted(fault.value for fault in self._left))
