"""What the simulated analyzer is like: the section `instrument` of a scene."""

from __future__ import annotations

from dataclasses import dataclass

from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_simulator.faults import SceneError
from gpr20_survey.plan.robot_description import SIMULATED_IDENTITY as SIMULATED

NOT_CALIBRATED = 0
ALL_PARAMETERS = 15


@dataclass(frozen=True)
class InstrumentScene:
    """The simulated network analyzer.

    Attributes:
        manufacturer: First field of its identity.
        model: Second field, options joined to it with "/".
        serial: Third field; contains SIMULATED.
        firmware: Fourth field.
        calibration_accuracy: 0 none, 1 high, 2 power changed, 3 temperature moved, 4 low.
        setting_delay_s: How long a setting takes to have an effect [s].
        calibrated_parameters: Which S-parameters are calibrated: the sum of S11 = 1, S12 = 2,
            S21 = 4 and S22 = 8.
        temperature_c: What it says of its temperature [degC], in quarters.
        late_memory_s: Fault LATE_MEMORY: how long after the end of a sweep the display has it [s].
        late_bit_s: Fault LATE_BIT: how long the bit stays set after a trigger [s].
        slow_point_s: Fault SLOW_POINTS: time of one frequency of a sweep [s].
        other_serial: Faults OTHER_SERIAL and SWAPPED: the serial number; contains SIMULATED.
    """

    manufacturer: str = "Anritsu"
    model: str = "MS2026C/2"
    serial: str = SIMULATED
    firmware: str = "1.23"
    calibration_accuracy: int = bounded(NOT_CALIBRATED, 4, 1)
    setting_delay_s: float = bounded(0.0, 10.0, 0.0)
    calibrated_parameters: int = bounded(0, ALL_PARAMETERS, ALL_PARAMETERS)
    temperature_c: float = bounded(-40.0, 100.0, 40.0)
    late_memory_s: float = bounded(0.0, 60.0, 0.2)
    late_bit_s: float = bounded(0.0, 60.0, 0.3)
    slow_point_s: float = bounded(0.0, 10.0, 2e-3)
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
