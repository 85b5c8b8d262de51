"""What the operator must know before anything else."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional


class AlarmKind(enum.Enum):
    """What is wrong with the way to the robot."""

    MASTER_GONE = "master gone"
    CONTROL_NEVER_HEARD = "control never heard"
    CONTROL_SILENT = "control silent"
    SURVEY_INTERRUPTED = "survey interrupted"
    ANALYZER_GONE = "analyzer gone"


@dataclass(frozen=True)
class Alarm:
    """An alarm, with what is known about it.

    Attributes:
        kind: What is wrong.
        silent_s: For how long nothing has been heard [s]; 0 if that says nothing.
        detail: What the robot itself says, in its own words.
    """

    kind: AlarmKind
    silent_s: float = 0.0
    detail: str = ""


def worst_alarm(
    master_alive: bool,
    control_silent_s: Optional[float],
    limit_s: float,
    interrupted: bool,
    analyzer_trouble: str,
) -> Optional[Alarm]:
    """Return the alarm that explains the others; None if all is well.

    Args:
        master_alive: Whether the ROS master answers.
        control_silent_s: For how long main_control has been silent [s]; None if it never spoke.
        limit_s: Silence of main_control that is an alarm [s].
        interrupted: Whether a survey vanished without an end, and none runs since.
        analyzer_trouble: What the VNA's node says is wrong with it; empty if nothing.
    """
    if not master_alive:
        return Alarm(AlarmKind.MASTER_GONE, control_silent_s or 0.0)
    if control_silent_s is None:
        return Alarm(AlarmKind.CONTROL_NEVER_HEARD)
    if control_silent_s > limit_s:
        return Alarm(AlarmKind.CONTROL_SILENT, control_silent_s)
    if interrupted:
        return Alarm(AlarmKind.SURVEY_INTERRUPTED)
    if analyzer_trouble:
        return Alarm(AlarmKind.ANALYZER_GONE, detail=analyzer_trouble)
    return None
