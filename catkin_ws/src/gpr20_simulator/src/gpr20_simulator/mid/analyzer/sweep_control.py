"""The commands that start, stop and watch the sweeps of the simulated analyzer."""

from __future__ import annotations

from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer import scpi
from gpr20_simulator.mid.analyzer.front_panel import Change, hand_changes
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.sweep_plan import SweepFaults
from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.analyzer.vna_commands import SWEEP_TYPES, on_off
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings

SWEEP_COMPLETE = 256


class SweepControl:
    """Triggers, hold and continuous sweeps, and the bit that shows the end of a sweep.

    Args:
        sweeper: The receiver.
        clock: Its seconds are those of the sweeps.
        faults: What goes wrong now.
        description: How the faults look.
        by_hand: Changes the settings, called from another thread in the middle of a sweep.
    """

    def __init__(
        self,
        sweeper: Sweeper,
        clock: Clock,
        faults: FaultBoard,
        description: InstrumentScene,
        by_hand: Callable[[Change], None],
    ) -> None:
        self._sweeper = sweeper
        self._clock = clock
        self._faults = faults
        self._description = description
        self._by_hand = by_hand
        self._bit_set_until_s: Optional[float] = None

    def operation_status(self) -> str:
        """Answer `:STATus:OPERation?`."""
        return str(SWEEP_COMPLETE if self._bit() else 0)

    def runs_continuously(self) -> str:
        """Answer `:INITiate:CONTinuous?`."""
        return on_off(self._sweeper.is_continuous and self._sweeper.is_running)

    def is_held(self) -> str:
        """Answer `:INITiate:HOLD?`."""
        return on_off(not self._sweeper.is_running)

    def sweep_type(self, settings: VnaSettings) -> str:
        """Answer `:SWEep:TYPE?`."""
        if settings.is_external:
            return "EXT"
        return "CONT" if self._sweeper.is_continuous else "SING"

    def trigger(self, settings: VnaSettings) -> None:
        """Run one sweep."""
        # With an external trigger nothing but that trigger starts a sweep; there is none here.
        if settings.is_external:
            return
        keeps_bit = self._bit() and self._faults.strikes(VnaFault.LATE_BIT)
        self._bit_set_until_s = (
            self._clock.now_s() + self._description.late_bit_s if keeps_bit else None
        )
        changes = hand_changes(self._faults)
        is_late = self._faults.strikes(VnaFault.LATE_MEMORY)
        is_slow = self._faults.strikes(VnaFault.SLOW_POINTS)
        sweep_faults = SweepFaults(
            stale=self._faults.strikes(VnaFault.STALE),
            slowest_point_s=self._description.slow_point_s if is_slow else 0.0,
            shown_late_s=self._description.late_memory_s if is_late else 0.0,
            midway=(lambda: [self._by_hand(one) for one in changes]) if changes else None,
        )
        self._sweeper.trigger(sweep_faults)

    def set_continuous(self, settings: VnaSettings, argument: str) -> None:
        """Carry out `:INITiate:CONTinuous`."""
        continuous = scpi.switch(argument)
        settings.is_external = False
        self._sweeper.set_continuous(continuous)

    def hold(self, settings: VnaSettings, argument: str) -> None:
        """Carry out `:INITiate:HOLD`; its end resumes a series, or else runs one sweep."""
        held = scpi.switch(argument)
        if held or self._sweeper.is_continuous:
            self._sweeper.hold(held)
        else:
            self.trigger(settings)

    def set_sweep_type(self, settings: VnaSettings, argument: str) -> None:
        """Carry out `:SWEep:TYPE`."""
        sweep_type = scpi.chosen_keyword(argument, SWEEP_TYPES)
        if not self._faults.strikes(VnaFault.REFUSE_SETTINGS):
            settings.is_external = sweep_type == "EXT"
            self._sweeper.set_continuous(sweep_type == "CONT")

    def _bit(self) -> bool:
        if self._bit_set_until_s is not None:
            if self._clock.now_s() < self._bit_set_until_s:
                return True
            self._bit_set_until_s = None
        return self._sweeper.is_complete
