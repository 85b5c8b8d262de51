"""What a sweep covers, and the frequencies that follow from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.checks import number_between
from gpr20_vna_acquisition.errors import VnaDataError, VnaParameterError

# The instrument may round to the resolution of its synthesizer.
RESOLUTION_HZ = 1.0
# Frequencies may have travelled in single precision, rounded once by it and once by us.
SINGLE_PRECISION_STEPS = 2.0


@dataclass(frozen=True)
class InstrumentRange:
    """What the instrument can be set to.

    The defaults are those of the MS2026C (MS20xxC programming manual, chapter 3), except
    that it would take 4001 points.
    """

    min_frequency_hz: float = 5e3
    max_frequency_hz: float = 6e9
    min_points: int = 2
    max_points: int = 4000


@dataclass(frozen=True)
class SweepSettings:
    """Start and stop frequency [Hz], both measured, and the number of points."""

    start_frequency_hz: float
    stop_frequency_hz: float
    points: int

    def check(self, allowed: InstrumentRange) -> None:
        """Refuse what the instrument cannot measure.

        Raises:
            VnaParameterError: A value is outside its range, or start is not below stop.
        """
        lower, upper = allowed.min_frequency_hz, allowed.max_frequency_hz
        try:
            number_between("start frequency", self.start_frequency_hz, lower, upper, "Hz")
            number_between("stop frequency", self.stop_frequency_hz, lower, upper, "Hz")
            number_between(
                "number of frequency points", self.points, allowed.min_points, allowed.max_points
            )
        except InvalidValueError as error:
            raise VnaParameterError(str(error)) from error
        if not self.start_frequency_hz < self.stop_frequency_hz:
            raise VnaParameterError(
                f"start frequency is {self.start_frequency_hz:.12g} Hz; it must be below "
                f"the stop frequency, which is {self.stop_frequency_hz:.12g} Hz"
            )

    def frequencies_hz(self) -> np.ndarray:
        """Return the measured frequencies [Hz, float64], ascending."""
        return np.linspace(self.start_frequency_hz, self.stop_frequency_hz, self.points)

    def check_reported(self, reported_hz: np.ndarray) -> None:
        """Compare the instrument's own list with ours.

        The list is not used itself: in single precision it is wrong by up to 256 Hz.

        Args:
            reported_hz: The list the instrument gives [Hz].

        Raises:
            VnaDataError: They differ by more than single precision explains.
        """
        expected_hz = self.frequencies_hz()
        spacing_hz = np.spacing(expected_hz.astype(np.float32)).astype(np.float64)
        tolerance_hz = SINGLE_PRECISION_STEPS * spacing_hz + RESOLUTION_HZ
        wrong = np.abs(reported_hz - expected_hz) > tolerance_hz
        if wrong.any():
            first = int(np.argmax(wrong))
            raise VnaDataError(
                f"the instrument measures {reported_hz[first]:.12g} Hz at point {first}, where "
                f"{expected_hz[first]:.12g} Hz follow from start, stop and points; "
                "check that it sweeps linearly"
            )
