"""What the simulated analyzer is like: the section `instrument` of a scene."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Tuple

from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_simulator.faults import SceneError
from gpr20_survey.plan.robot_description import SIMULATED_IDENTITY as SIMULATED

NOT_CALIBRATED = 0
ALL_PARAMETERS = 15


class Averaging(enum.Enum):
    """When a triggered sweep with averaging is complete; public documents do not say."""

    EACH_SWEEP = "each_sweep"  # after one sweep; the average rolls over the triggers
    ALL_SWEEPS = "all_sweeps"  # after as many new sweeps as are averaged


class Power(enum.Enum):
    """Output power of the source; the values are what the instrument calls them."""

    LOW = "LOW"
    HIGH = "HIGH"


@dataclass(frozen=True)
class InstrumentScene:
    """The simulated network analyzer.

    Attributes:
        manufacturer: First field of its identity.
        model: Second field, options joined to it with "/".
        serial: Third field; contains SIMULATED.
        firmware: Fourth field.
        calibration_accuracy: 0 none, 1 high, 2 power changed, 3 temperature moved, 4 low.
        calibration_power: Output power of the calibration; with the other one its accuracy is
            2 at best.
        setting_delay_s: How long a setting takes to have an effect [s].
        trailing_comma: Whether ASCII data end with a comma.
        trailing_newline: Whether a newline follows a data block.
        header_digits: Digits of a block's length, zero padded; 0: as few as it needs.
        ascii_digits: Digits after the point in ASCII data; 8 keep a float32 exactly.
        averaging: When a triggered sweep with averaging is complete.
        message_s: Time that each message to the instrument takes [real s].
        calibrated_parameters: Which S-parameters are calibrated: the sum of S11 = 1, S12 = 2,
            S21 = 4 and S22 = 8.
        calibration_type: How it was calibrated, as the instrument calls it.
        calibration_interpolated: Whether the calibration is interpolated between its points.
        temperature_c: What it says of its temperature [degC], in quarters.
        smoothing_percent: How much of the sweep is averaged for each point of the display [%].
        trace_math: How the display combines a trace with its memory: 0 not at all.
        late_memory_s: Fault LATE_MEMORY: how long after the end of a sweep the display has it [s].
        late_bit_s: Fault LATE_BIT: how long the bit stays set after a trigger [s].
        slow_point_s: Fault SLOW_POINTS: time of one frequency of a sweep [s].
        unanswered_queries: Fault UNANSWERED_QUERY: the queries that get no answer.
        other_serial: Faults OTHER_SERIAL and SWAPPED: the serial number; contains SIMULATED.
    """

    manufacturer: str = "Anritsu"
    model: str = "MS2026C/2"
    serial: str = SIMULATED
    firmware: str = "1.23"
    calibration_accuracy: int = bounded(NOT_CALIBRATED, 4, 1)
    calibration_power: Power = Power.HIGH
    setting_delay_s: float = bounded(0.0, 10.0, 0.0)
    trailing_comma: bool = True
    trailing_newline: bool = True
    header_digits: int = bounded(0, 9, 0)
    ascii_digits: int = bounded(2, 16, 8)
    averaging: Averaging = Averaging.EACH_SWEEP
    message_s: float = bounded(0.0, 5.0, 0.0)
    calibrated_parameters: int = bounded(0, ALL_PARAMETERS, ALL_PARAMETERS)
    calibration_type: str = "RF2P"
    calibration_interpolated: bool = False
    temperature_c: float = bounded(-40.0, 100.0, 40.0)
    smoothing_percent: int = bounded(0, 20, 0)
    trace_math: int = bounded(0, 4, 0)
    late_memory_s: float = bounded(0.0, 60.0, 0.2)
    late_bit_s: float = bounded(0.0, 60.0, 0.3)
    slow_point_s: float = bounded(0.0, 10.0, 2e-3)
    unanswered_queries: Tuple[str, ...] = (":SENS:TRACE1:DOM?",)
    other_serial: str = f"{SIMULATED}-2"

    def __post_init__(self) -> None:
        for serial in (self.serial, self.other_serial):
            if SIMULATED not in serial:
                raise SceneError(
                    Message(
                        "the serial number of the simulated VNA is {serial}; it must contain "
                        "{marker}, so that its data are never taken for those of a real one",
                        serial=repr(serial),
                        marker=SIMULATED,
                    )
                )
