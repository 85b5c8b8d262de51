"""What the antennas look into."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gpr20_simulator.mid.antenna_position import AntennaPosition


class SweptMedium(Protocol):
    """Anything that has a transmission between the two antennas."""

    def s21(
        self, frequency_hz: np.ndarray, position: AntennaPosition, sweep_number: int
    ) -> np.ndarray:
        """Return the complex transmission at each frequency.

        Args:
            frequency_hz: Frequencies [Hz].
            position: Where the antennas are while these frequencies are measured.
            sweep_number: Number of the sweep that these points belong to.
        """
