"""One sweep, and the calibration with which it was made."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from gpr20_vna_acquisition.mid.sweep_settings import SweepSettings


class CalibrationStatus(enum.IntEnum):
    """The calibration by the instrument's own scale; its order is not one of quality."""

    NONE = 0
    HIGH = 1
    MODERATE_POWER = 2
    MODERATE_TEMPERATURE = 3
    LOW = 4


@dataclass(frozen=True)
class Sweep:
    """One complete sweep.

    Attributes:
        s21_real: Real part, linear [float64].
        s21_imag: Imaginary part, linear [float64], same length.
        started_us: Just before it was triggered [microseconds since 1970, UTC].
        ended_us: When its end was seen [microseconds since 1970, UTC].
        quality: Remarks on the quality; empty means none.
        settings: The sweep as the instrument confirmed it, once the driver has taken it over.
        calibration: The calibration after the sweep, likewise.
    """

    s21_real: np.ndarray
    s21_imag: np.ndarray
    started_us: int
    ended_us: int
    quality: Tuple[str, ...] = ()
    settings: Optional[SweepSettings] = None
    calibration: CalibrationStatus = CalibrationStatus.NONE

    @property
    def duration_s(self) -> float:
        """How long it took [s]."""
        return (self.ended_us - self.started_us) * 1e-6

    def same_data(self, other: Sweep) -> bool:
        """Return whether every bit of the measured data is the same."""
        return (
            self.s21_real.tobytes() == other.s21_real.tobytes()
            and self.s21_imag.tobytes() == other.s21_imag.tobytes()
        )
