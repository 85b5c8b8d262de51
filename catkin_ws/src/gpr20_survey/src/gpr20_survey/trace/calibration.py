"""The state of the network analyzer's calibration."""

from __future__ import annotations

import enum

from gpr20_common.message import Message


class CalibrationStatus(enum.IntEnum):
    """The calibration by the scale of the MS2026C; its order is not one of quality.

    NOT_REPORTED is not on that scale: the analyzer does not say how good its calibration is, or
    whether it has one.
    """

    NONE = 0
    HIGH = 1
    MODERATE_POWER = 2
    MODERATE_TEMPERATURE = 3
    LOW = 4
    NOT_REPORTED = 5

    @property
    def meaning(self) -> Message:
        return {
            CalibrationStatus.NONE: Message("no calibration"),
            CalibrationStatus.HIGH: Message("calibrated, accuracy high"),
            CalibrationStatus.MODERATE_POWER: Message(
                "moderate, power level changed since calibration"
            ),
            CalibrationStatus.MODERATE_TEMPERATURE: Message(
                "moderate, temperature changed by more than 5 degrees since calibration"
            ),
            CalibrationStatus.LOW: Message(
                "low, temperature changed by more than 10 degrees since calibration"
            ),
            CalibrationStatus.NOT_REPORTED: Message("not reported by this analyzer"),
        }[self]
