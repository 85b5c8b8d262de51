"""Faults of the simulated devices that can be switched while they work."""

from __future__ import annotations

import enum
from typing import Dict, Type

from gpr20_common.message import Message
from gpr20_simulator.errors import FaultError
from gpr20_simulator.low.shared_state import AdcFault, EndstopFault, SharedState
from gpr20_simulator.mid.analyzer.vna_faults import TIMED, FaultBoard, unknown_fault
from gpr20_survey.axes.axis_id import AxisId

NO_FAULT = "NONE"
VNA = "vna"
ADC = "adc"
ENDSTOPS: Dict[str, AxisId] = {"endstop_x": AxisId.X, "endstop_y": AxisId.Y}


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
            count: How many times a fault of the analyzer strikes, or how many seconds a timed
                one lasts; 0: until switched off.

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
        if count and fault.upper() in {one.value for one in TIMED}:
            return Message(
                "SIMULATED {device}: fault {fault} for {count} s",
                device=device,
                fault=fault.upper(),
                count=count,
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
        raise unknown_fault(fault, allowed)
    return fault.upper()
