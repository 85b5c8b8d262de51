"""What somebody may change at the front panel while a client works."""

from __future__ import annotations

from typing import Callable, Dict, List

from gpr20_simulator.mid.analyzer.instrument_scene import Power
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault
from gpr20_simulator.mid.analyzer.vna_settings import HIGHEST_HZ, POWER_ON_BANDWIDTH_HZ, VnaSettings

OTHER_BANDWIDTH_HZ = 1000
OTHER_AVERAGES = 4
MOVED_START_HZ = 1e6

Change = Callable[[VnaSettings], None]


def _change_bandwidth(settings: VnaSettings) -> None:
    is_other = settings.bandwidth_hz == OTHER_BANDWIDTH_HZ
    settings.bandwidth_hz = POWER_ON_BANDWIDTH_HZ if is_other else OTHER_BANDWIDTH_HZ


def _change_averages(settings: VnaSettings) -> None:
    settings.averages = 1 if settings.averages == OTHER_AVERAGES else OTHER_AVERAGES


def _change_power(settings: VnaSettings) -> None:
    settings.power = Power.LOW if settings.power is Power.HIGH else Power.HIGH


def _change_start(settings: VnaSettings) -> None:
    is_room_above = settings.start_hz + MOVED_START_HZ <= HIGHEST_HZ
    settings.set_start(settings.start_hz + (MOVED_START_HZ if is_room_above else -MOVED_START_HZ))


CHANGES: Dict[VnaFault, Change] = {
    VnaFault.HAND_BANDWIDTH: _change_bandwidth,
    VnaFault.HAND_AVERAGES: _change_averages,
    VnaFault.HAND_POWER: _change_power,
    VnaFault.HAND_START: _change_start,
}


def hand_changes(faults: FaultBoard) -> List[Change]:
    """Return what somebody changes, one after the other, during the sweep that begins now."""
    struck = [change for fault, change in CHANGES.items() if faults.strikes(fault)]
    if faults.strikes(VnaFault.HAND_PUT_BACK):
        # The other bandwidth, and the one of before.
        struck += [_change_bandwidth, _change_bandwidth]
    return struck
