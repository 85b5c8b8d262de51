"""Faults of the simulated devices that can be switched while they work."""

from __future__ import annotations

import enum
import threading
from typing import Dict, Type

from gpr20_common.message import Message
from gpr20_simulator.errors import FaultError
from gpr20_simulator.low.shared_state import AdcFault, EndstopFault, SharedState
from gpr20_survey.axes.axis_id import AxisId

MOST_TIMES = 1_000_000
UNTIL_CLEARED = 0
NO_FAULT = "NONE"
VNA = "vna"
ADC = "adc"
ENDSTOPS: Dict[str, AxisId] = {"endstop_x": AxisId.X, "endstop_y": AxisId.Y}


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
            raise _unknown_fault(name, f"NONE, {names}")
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


class FaultSwitch:
    """Knows the devices and their faults.

    Args:
        state: Holds the faults of endstops and converter, which other processes simulate.
        vna_faults: The faults of the network analyzer.
    """

    def __init__(self, state: SharedState, vna_faults: FaultBoard) -> None:
        self._state = state
        self._vna_faults = vna_faults

    def set(self, device: str, fault: str, count: int) -> Message:
        """Switch a fault on, or with "none" all faults of the device off.

        Args:
            device: vna, endstop_x, endstop_y or adc.
            fault: Name of the fault, in capitals or not.
            count: How many times a fault of the analyzer strikes; 0: until switched off.

        Returns:
            The fault that is on now.

        Raises:
            FaultError: Device, fault or count is not allowed; the message lists what is.
        """
        if device == VNA:
            self._set_vna(fault, count)
        elif device == ADC:
            self._state.adc_fault = AdcFault[_name_of(AdcFault, fault, count)]
        elif device in ENDSTOPS:
            chosen = EndstopFault[_name_of(EndstopFault, fault, count)]
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
        if count:
            return Message(
                "SIMULATED {device}: fault {fault}, {count} times",
                device=device,
                fault=fault.upper(),
                count=count,
            )
        return Message("SIMULATED {device}: fault {fault}", device=device, fault=fault.upper())

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

    def _set_vna(self, fault: str, count: int) -> None:
        if fault.upper() == NO_FAULT:
            self._vna_faults.clear()
        else:
            self._vna_faults.set(fault, count)


def _name_of(faults: Type[enum.IntEnum], fault: str, count: int) -> str:
    if count != 0:
        raise FaultError(
            Message(
                "count is {count}; it must be 0, because faults of endstops and converter stay "
                "until they are set to none",
                count=count,
            )
        )
    if fault.upper() not in faults.__members__:
        allowed = ", ".join(faults.__members__)
        raise _unknown_fault(fault, allowed)
    return fault.upper()


def _unknown_fault(fault: str, allowed: str) -> FaultError:
    return FaultError(
        Message("unknown fault '{fault}'; allowed: {allowed}", fault=fault[:40], allowed=allowed)
    )
