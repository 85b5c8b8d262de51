"""The state of the network analyzer's calibration."""

from __future__ import annotations

import enum


class CalibrationStatus(enum.IntEnum):
    """The calibration by the instrument's own scale; its order is not one of quality."""

    NONE = 0
    HIGH = 1
    MODERATE_POWER = 2
    MODERATE_TEMPERATURE = 3
    LOW = 4

    @property
    def meaning(self) -> str:
        """What it says of the calibration, for people."""
        return MEANINGS[self]


MEANINGS = {
    CalibrationStatus.NONE: "no calibration",
    CalibrationStatus.HIGH: "calibrated, accuracy high",
    CalibrationStatus.MODERATE_POWER: "moderate, the power level was changed",
    CalibrationStatus.MODERATE_TEMPERATURE: (
        "moderate, the temperature moved by more than 5 degrees"
    ),
    CalibrationStatus.LOW: "low, the temperature moved by more than 10 degrees",
}
