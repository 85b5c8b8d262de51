"""Whether it matters how finely a series of sweeps is simulated just now."""

from __future__ import annotations

from typing import Optional

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.sweep_plan import SweepPace
from gpr20_simulator.mid.world.medium import AntennaPosition


class Attention:
    """Knows when data were read last and when the antennas moved last.

    Args:
        clock: Its seconds are those of the pace.
        pace: How long a reader or a move is waited for.
    """

    def __init__(self, clock: Clock, pace: SweepPace) -> None:
        self._clock = clock
        self._pace = pace
        self._position: Optional[AntennaPosition] = None
        self._moved_until_s = self._read_until_s = clock.now_s()

    @property
    def is_read(self) -> bool:
        """Whether somebody has read data a short time ago."""
        return self._clock.now_s() < self._read_until_s

    @property
    def is_needed(self) -> bool:
        """Whether it matters where the antennas are at each moment."""
        return self.is_read or self._clock.now_s() < self._moved_until_s

    def note_read(self) -> None:
        """Take note that somebody reads data."""
        self._read_until_s = self._clock.now_s() + self._pace.attention_s

    def note_position(self, position: AntennaPosition) -> None:
        """Take note of where the antennas are."""
        if position != self._position:
            self._position = position
            self._moved_until_s = self._clock.now_s() + self._pace.attention_s
