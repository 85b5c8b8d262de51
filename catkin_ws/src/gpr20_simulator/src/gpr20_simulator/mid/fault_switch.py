"""Switching the faults of all simulated devices by name."""

from __future__ import annotations

import enum
from typing import Dict, Type

from gpr20_simulator.errors import FaultError
from gpr20_simulator.low.world import AdcFault, AxisName, EndstopFault, World
from gpr20_simulator.mid.faults import FaultBoard

NO_FAULT = "NONE"
VNA = "vna"
ADC = "adc"
ENDSTOPS: Dict[str, AxisName] = {"endstop_x": AxisName.X, "endstop_y": AxisName.Y}


class FaultSwitch:
    """Knows the devices and their faults.

    Args:
        world: Holds the faults of endstops and converter, which other processes simulate.
        vna_faults: The faults of the network analyzer.
    """

    def __init__(self, world: World, vna_faults: FaultBoard) -> None:
        self._world = world
        self._vna_faults = vna_faults

    def set(self, device: str, fault: str, count: int) -> str:
        """Switch a fault on, or with "none" all faults of the device off.

        Args:
            device: vna, endstop_x, endstop_y or adc.
            fault: Name of the fault, in capitals or not.
            count: How many times a fault of the analyzer strikes; 0: until switched off.

        Returns:
            A sentence that says what is so now.

        Raises:
            FaultError: Device, fault or count is not allowed; the message lists what is.
        """
        if device == VNA:
            self._set_vna(fault, count)
        elif device == ADC:
            self._world.adc_fault = AdcFault[_name_of(AdcFault, fault, count)]
        elif device in ENDSTOPS:
            chosen = EndstopFault[_name_of(EndstopFault, fault, count)]
            self._world.set_endstop_fault(ENDSTOPS[device], chosen)
        else:
            devices = ", ".join((VNA, *ENDSTOPS, ADC))
            raise FaultError(f"unknown device '{device[:40]}'; allowed are {devices}")
        times = f", {count} times" if count else ""
        return f"SIMULATED {device}: fault {fault.upper()}{times}"

    def names(self) -> str:
        """Return the faults that are on, for people; empty if there is none."""
        found = [f"vna {self._vna_faults.names()}"] if self._vna_faults.names() else []
        for device, axis in ENDSTOPS.items():
            endstop_fault = self._world.endstop_fault(axis)
            if endstop_fault is not EndstopFault.NONE:
                found.append(f"{device} {endstop_fault.name}")
        if self._world.adc_fault is not AdcFault.NONE:
            found.append(f"{ADC} {self._world.adc_fault.name}")
        return ", ".join(found)

    def _set_vna(self, fault: str, count: int) -> None:
        if fault.upper() == NO_FAULT:
            self._vna_faults.clear()
        else:
            self._vna_faults.set(fault, count)


def _name_of(faults: Type[enum.IntEnum], fault: str, count: int) -> str:
    if count != 0:
        raise FaultError(
            f"count is {count}; faults of endstops and converter stay until they are set to none, "
            "so it must be 0"
        )
    if fault.upper() not in faults.__members__:
        allowed = ", ".join(faults.__members__)
        raise FaultError(f"unknown fault '{fault[:40]}'; allowed are {allowed}")
    return fault.upper()
