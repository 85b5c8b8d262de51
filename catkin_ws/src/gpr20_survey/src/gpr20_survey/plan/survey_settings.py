"""How the control carries out surveys; set for a robot, not for a survey."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between


class HeightPolicy(enum.Enum):
    """What a survey does when the antenna height cannot be measured."""

    PAUSE = "pause"
    STORE_WITHOUT = "store_without"


@dataclass(frozen=True)
class SurveySettings:
    """How the control carries out surveys.

    Attributes:
        settle_s: Time for vibrations to die down between a move and the sweep [s].
        height_s: Time that the height measurement takes [s]; for the estimate only.
        attempts: How often a height measurement is tried before the survey pauses.
        on_height_failure: `pause`, or `store_without` to store the trace with no height.
        return_limit_s: How long a survey waits for a node that is gone, or for a link that is
            down, before it pauses [s].
        repeat_limit_db: A point that is measured again agrees with its stored trace if they differ
            by no more than this, relative to the trace [dB].
        reference_interval_s: Time after which the survey returns to its first stop to see the
            drift [s]; a shorter survey never returns. 0: none does.
        drift_limit_db: Largest drift of the amplitude, root mean square over the band [dB]; after
            a larger one the survey pauses.
        drift_limit_deg: Largest drift of the phase, root mean square over the band [deg]; after a
            larger one the survey pauses.
    """

    settle_s: float = 0.5
    height_s: float = 0.4
    attempts: int = 3
    on_height_failure: str = HeightPolicy.PAUSE.value
    return_limit_s: float = 300.0
    repeat_limit_db: float = -20.0
    reference_interval_s: float = 3600.0
    drift_limit_db: float = 1.0
    drift_limit_deg: float = 10.0

    def __post_init__(self) -> None:
        number_between("settle_s", self.settle_s, 0.0, 60.0, "s")
        number_between("height_s", self.height_s, 0.0, 60.0, "s")
        number_between("return_limit_s", self.return_limit_s, 0.0, 3600.0, "s")
        number_between("repeat_limit_db", self.repeat_limit_db, -100.0, 0.0, "dB")
        number_between("reference_interval_s", self.reference_interval_s, 0.0, 1.0e6, "s")
        number_between("drift_limit_db", self.drift_limit_db, 0.01, 100.0, "dB")
        number_between("drift_limit_deg", self.drift_limit_deg, 0.1, 180.0, "deg")
        number_between("attempts", self.attempts, 1, 100)
        policies = [policy.value for policy in HeightPolicy]
        if self.on_height_failure not in policies:
            raise InvalidValueError(
                Message(
                    "{place} is {value}; it must be one of {allowed}",
                    place="on_height_failure",
                    value=repr(self.on_height_failure),
                    allowed=", ".join(policies),
                ),
                fault=CONFIGURATION,
            )
