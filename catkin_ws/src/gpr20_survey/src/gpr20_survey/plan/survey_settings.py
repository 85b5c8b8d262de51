"""How the control carries out surveys; set for a robot, not for a survey."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from gpr20_common.mid.codec import bounded


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

    settle_s: float = bounded(0.0, 60.0, 0.5)
    height_s: float = bounded(0.0, 60.0, 0.4)
    attempts: int = bounded(1, 100, 3)
    on_height_failure: HeightPolicy = HeightPolicy.PAUSE
    return_limit_s: float = bounded(0.0, 3600.0, 300.0)
    repeat_limit_db: float = bounded(-100.0, 0.0, -20.0)
    reference_interval_s: float = bounded(0.0, 1.0e6, 3600.0)
    drift_limit_db: float = bounded(0.01, 100.0, 1.0)
    drift_limit_deg: float = bounded(0.1, 180.0, 10.0)
