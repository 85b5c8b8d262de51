"""Errors of the simulated robot, and faults of its devices that are switched while they work."""

from __future__ import annotations

import enum
import threading
import time
from typing import Callable, Dict, Optional, Set, Type

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Fault, Message, Severity
from gpr20_common.mid.checks import number_between
from gpr20_simulator.low.shared_state import AdcFault, EndstopFault, SharedState
from gpr20_survey.axes import AxisId

FAULTS_SET = Fault(
    "simulator.faults_set",
    Message("When the test is over, end the fault with simulator/set_fault."),
    Severity.WARNING,
)
MOST_TIMES = 1_000_000
UNTIL_CLEARED = 0
NO_FAULT = "NONE"
VNA = "vna"
ADC = "adc"
ENDSTOPS: Dict[str, AxisId] = {"endstop_x": AxisId.X, "endstop_y": AxisId.Y}


class SimulatorError(Gpr20Error):
    """Something about the simulated robot was refused or failed."""

    fault = NOT_ALLOWED


class SceneError(SimulatorError, ValueError):
    """A scene file is missing, is not YAML or holds a key or value that is not allowed."""


class FaultError(SimulatorError, ValueError):
    """A fault was asked for that does not exist."""


class VnaFault(enum.Enum):
    """What can go wrong with the analyzer, and what a count counts."""

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
    OTHER_SERIAL = "OTHER_SERIAL"  # new links whose *IDN? has another serial number
    SWAPPED = "SWAPPED"  # nothing: another unit answers on the same link as long as it is on
    LINK_GONE = "LINK_GONE"  # real seconds without any connection
    LOSES_CALIBRATION = "LOSES_CALIBRATION"  # settings of the sweep that end the calibration
    ENDLESS_DIGITS = "ENDLESS_DIGITS"  # numeric answers of 40,000 digits and a letter
    HAND_BANDWIDTH = "HAND_BANDWIDTH"  # sweeps in whose middle somebody changes the bandwidth
    HAND_AVERAGES = "HAND_AVERAGES"  # sweeps in whose middle somebody changes the averages
    HAND_POWER = "HAND_POWER"  # sweeps in whose middle somebody changes the output power
    HAND_START = "HAND_START"  # sweeps in whose middle somebody changes the start frequency
    LOOSE_PLUG = "LOOSE_PLUG"  # nothing: S21 is 3 dB lower and turned as long as it is on


class FaultBoard:
    """The faults of the analyzer that are on now; every method may be called from any thread.

    Args:
        now_s: Tells the real time [s] since some fixed moment.

    Attributes:
        on_link_gone: Called when that fault is switched on.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        self.on_link_gone: Callable[[], None] = lambda: None
        self._now_s = now_s
        self._lock = threading.Lock()
        self._left: Dict[VnaFault, int] = {}
        self._link_is_back_s: Optional[float] = None
        self._damaged: Set[VnaFault] = set()

    def set(self, name: str, count: int = UNTIL_CLEARED) -> None:
        """Switch a fault on.

        Args:
            name: Name of the fault, in capitals or not.
            count: How many times it strikes, or for LINK_GONE how many seconds it lasts; 0: until
                the faults are cleared.

        Raises:
            InvalidValueError: The count is not allowed.
            FaultError: There is no such fault.
        """
        number_between("count", count, 0, MOST_TIMES)
        if name.upper() not in VnaFault.__members__:
            raise _unknown(name, f"{NO_FAULT}, {', '.join(VnaFault.__members__)}")
        fault = VnaFault[name.upper()]
        with self._lock:
            self._left[fault] = count
            if fault is VnaFault.LINK_GONE:
                self._link_is_back_s = self._now_s() + count if count else None
        if fault is VnaFault.LINK_GONE:
            self.on_link_gone()

    def clear(self) -> None:
        """Switch every fault off and repair what they damaged."""
        with self._lock:
            self._left.clear()
            self._damaged.clear()

    def is_on(self, fault: VnaFault) -> bool:
        """Return whether the fault is on; this does not count as one time."""
        with self._lock:
            self._end_timed()
            return fault in self._left

    def is_permanent(self, fault: VnaFault) -> bool:
        """Return whether the fault stays until it is cleared."""
        with self._lock:
            return self._left.get(fault) == UNTIL_CLEARED

    def strikes(self, fault: VnaFault) -> bool:
        """Return whether the fault happens now; this counts as one time."""
        with self._lock:
            left = self._left.get(fault)
            if left == 1:
                del self._left[fault]
            elif left:
                self._left[fault] = left - 1
            return left is not None

    def damages(self, fault: VnaFault) -> None:
        """Let the fault happen, if it is on, with an effect that lasts until it is cleared."""
        if self.strikes(fault):
            with self._lock:
                self._damaged.add(fault)

    def has_damaged(self, fault: VnaFault) -> bool:
        """Return whether the fault has had an effect that lasts."""
        with self._lock:
            return fault in self._damaged

    def names(self) -> str:
        """Return the faults that are on or have an effect, for people; empty if there is none."""
        with self._lock:
            self._end_timed()
            return ", ".join(sorted(fault.value for fault in {*self._left, *self._damaged}))

    def _end_timed(self) -> None:
        if self._link_is_back_s is not None and self._now_s() >= self._link_is_back_s:
            self._left.pop(VnaFault.LINK_GONE, None)
            self._link_is_back_s = None


class FaultSwitch:
    """Knows the devices and their faults; those of other processes are in the shared state."""

    def __init__(self, state: SharedState, vna_faults: FaultBoard) -> None:
        self._state = state
        self._vna_faults = vna_faults

    def set(self, device: str, fault: str, count: int) -> Message:
        """Switch a fault on, or with "none" all faults of the device off.

        Args:
            device: vna, endstop_x, endstop_y or adc.
            fault: Name of the fault, in capitals or not.
            count: As for `FaultBoard.set`; 0 for every other device.

        Returns:
            The fault that is on now.

        Raises:
            InvalidValueError: The count is not allowed.
            FaultError: Device, fault or count is not allowed; the message lists what is.
        """
        name = fault.upper()
        if device == VNA and name == NO_FAULT:
            self._vna_faults.clear()
        elif device == VNA:
            self._vna_faults.set(name, count)
        elif device == ADC:
            self._state.adc_fault = AdcFault[_checked(AdcFault, name, count)]
        elif device in ENDSTOPS:
            chosen = EndstopFault[_checked(EndstopFault, name, count)]
            self._state.set_endstop_fault(ENDSTOPS[device], chosen)
        else:
            devices = ", ".join((VNA, *ENDSTOPS, ADC))
            raise FaultError(
                Message(
                    "unknown device '{device}'; allowed: {allowed}",
                    device=device[:40],
                    allowed=devices,
                )
            )
        if not count:
            return Message("SIMULATED {device}: fault {fault}", device=device, fault=name)
        values = {"device": device, "fault": name, "count": count}
        if name == VnaFault.LINK_GONE.value:
            return Message("SIMULATED {device}: fault {fault} for {count} s", **values)
        return Message("SIMULATED {device}: fault {fault}, {count} times", **values)

    def names(self) -> str:
        """Return the faults that are on, for people; empty if there is none."""
        found = [f"vna {self._vna_faults.names()}"] if self._vna_faults.names() else []
        for device, axis in ENDSTOPS.items():
            endstop_fault = self._state.endstop_fault(axis)
            if endstop_fault is not EndstopFault.NONE:
                found.append(f"{device} {endstop_fault.name}")
        if self._state.adc_fault is not AdcFault.NONE:
            found.append(f"{ADC} {self._state.adc_fault.name}")
        return ", ".join(found)


def _checked(faults: Type[enum.IntEnum], name: str, count: int) -> str:
    if count != 0:
        raise FaultError(
            Message(
                "count is {count}; it must be 0, because faults of endstops and converter stay "
                "until they are set to none",
                count=count,
            )
        )
    if name not in faults.__members__:
        raise _unknown(name, ", ".join(faults.__members__))
    return name


def _unknown(fault: str, allowed: str) -> FaultError:
    return FaultError(
        Message("unknown fault '{fault}'; allowed: {allowed}", fault=fault[:40], allowed=allowed)
    )
