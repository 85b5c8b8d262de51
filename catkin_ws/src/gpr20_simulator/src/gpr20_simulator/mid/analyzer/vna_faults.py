"""What can go wrong with the simulated analyzer, and what is going wrong now."""

from __future__ import annotations

import enum
import threading
import time
from typing import Callable, Dict, List, Set

from gpr20_common.message import Message
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
    LATE_BIT = "LATE_BIT"  # triggers after which the bit of the sweep before stays set for a while
    LATE_MEMORY = "LATE_MEMORY"  # triggers whose data reach the display after the end of the sweep
    SLOW_POINTS = "SLOW_POINTS"  # triggers whose sweep takes longer for each point
    UNANSWERED_QUERY = "UNANSWERED_QUERY"  # queries of the scene's list that get no answer
    OTHER_SERIAL = "OTHER_SERIAL"  # new links whose *IDN? has another serial number
    SWAPPED = "SWAPPED"  # nothing: another unit answers on the same link as long as it is on
    LINK_GONE = "LINK_GONE"  # real seconds without any connection
    LOSES_CALIBRATION = "LOSES_CALIBRATION"  # settings of the sweep that end the calibration
    ENDLESS_DIGITS = "ENDLESS_DIGITS"  # numeric answers of 40,000 digits and a letter
    NO_CLEAR = "NO_CLEAR"  # device_clear calls of which the server knows nothing
    CLEAR_UNSUPPORTED = "CLEAR_UNSUPPORTED"  # device_clear calls that get the error 8
    HAND_BANDWIDTH = "HAND_BANDWIDTH"  # sweeps in whose middle somebody changes the bandwidth
    HAND_AVERAGES = "HAND_AVERAGES"  # sweeps in whose middle somebody changes the averages
    HAND_POWER = "HAND_POWER"  # sweeps in whose middle somebody changes the output power
    HAND_PUT_BACK = "HAND_PUT_BACK"  # sweeps in whose middle the bandwidth is changed and put back
    HAND_START = "HAND_START"  # sweeps in whose middle somebody changes the start frequency
    LOOSE_PLUG = "LOOSE_PLUG"  # nothing: S21 is 3 dB lower and turned as long as it is on


# Their count is a number of seconds, whatever happens meanwhile.
TIMED = frozenset({VnaFault.LINK_GONE})


class FaultBoard:
    """The faults that are on now; every method may be called from any thread.

    Args:
        now_s: Tells the real time [s] since some fixed moment.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        self._now_s = now_s
        self._lock = threading.Lock()
        self._left: Dict[VnaFault, int] = {}
        self._end_s: Dict[VnaFault, float] = {}
        self._damaged: Set[VnaFault] = set()
        self._listeners: List[Callable[[VnaFault], None]] = []

    def on_set(self, listener: Callable[[VnaFault], None]) -> None:
        """Call the listener with each fault that is switched on from now on."""
        with self._lock:
            self._listeners.append(listener)

    def set(self, name: str, count: int = UNTIL_CLEARED) -> None:
        """Switch a fault on.

        Args:
            name: Name of the fault, in capitals or not.
            count: How many times it strikes, or how many seconds a timed one lasts; 0: until
                the faults are cleared.

        Raises:
            FaultError: There is no such fault, or the count is not allowed.
        """
        if not 0 <= count <= MOST_TIMES:
            raise FaultError(
                Message(
                    "{name} is {value}; it must lie between {lower} and {upper}",
                    name="count",
                    value=count,
                    lower=0,
                    upper=MOST_TIMES,
                )
            )
        fault = next((one for one in VnaFault if one.value == name.upper()), None)
        if fault is None:
            names = ", ".join(one.value for one in VnaFault)
            raise unknown_fault(name, f"NONE, {names}")
        with self._lock:
            self._left[fault] = count
            if fault in TIMED and count != UNTIL_CLEARED:
                self._end_s[fault] = self._now_s() + count
            else:
                self._end_s.pop(fault, None)
            listeners = list(self._listeners)
        for listener in listeners:
            listener(fault)

    def clear(self) -> None:
        """Switch every fault off and repair what they damaged."""
        with self._lock:
            self._left.clear()
            self._end_s.clear()
            self._damaged.clear()

    def is_on(self, fault: VnaFault) -> bool:
        """Return whether the fault is on; this does not count as one time."""
        if not self._left:
            return False
        with self._lock:
            return self._is_on(fault)

    def is_permanent(self, fault: VnaFault) -> bool:
        """Return whether the fault stays until it is cleared."""
        with self._lock:
            return self._left.get(fault) == UNTIL_CLEARED

    def strikes(self, fault: VnaFault) -> bool:
        """Return whether the fault happens now; this counts as one time."""
        if not self._left:
            return False
        with self._lock:
            if not self._is_on(fault):
                return False
            left = self._left[fault]
            if left == 1:
                del self._left[fault]
            elif left > 1:
                self._left[fault] = left - 1
            return True

    def damages(self, fault: VnaFault) -> bool:
        """Let the fault happen, if it is on, with an effect that lasts until it is cleared."""
        happens = self.strikes(fault)
        if happens:
            with self._lock:
                self._damaged.add(fault)
        return happens

    def has_damaged(self, fault: VnaFault) -> bool:
        """Return whether the fault has had an effect that lasts."""
        with self._lock:
            return fault in self._damaged

    def names(self) -> str:
        """Return the faults that are on or have an effect, for people; empty if there is none."""
        with self._lock:
            shown = {fault for fault in tuple(self._left) if self._is_on(fault)} | self._damaged
            return ", ".join(sorted(fault.value for fault in shown))

    def _is_on(self, fault: VnaFault) -> bool:
        end_s = self._end_s.get(fault)
        if end_s is not None and self._now_s() >= end_s:
            del self._left[fault]
            del self._end_s[fault]
        return fault in self._left


def unknown_fault(fault: str, allowed: str) -> FaultError:
    """Return the error for a fault that does not exist."""
    return FaultError(
        Message("unknown fault '{fault}'; allowed: {allowed}", fault=fault[:40], allowed=allowed)
    )
