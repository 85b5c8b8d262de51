"""The states of a survey."""

from __future__ import annotations

import enum

from gpr20_common.message import Message


class SurveyState(enum.IntEnum):
    """What the control is doing; the values are those of gpr20_msgs/ControlStatus."""

    IDLE = 0
    CONFIGURED = 1
    CHECKING = 2
    HOMING = 3
    SURVEYING = 4
    PAUSED = 5
    STOPPING = 6
    FINISHED = 7
    STOPPED = 8
    FAILED = 9
    PAUSING = 10

    @property
    def running(self) -> bool:
        """Whether a survey is in progress, paused or not."""
        return self in RUNNING

    @property
    def label(self) -> Message:
        """Its name, for people."""
        return _LABELS[self]


RUNNING = frozenset(
    {
        *(SurveyState.CHECKING, SurveyState.HOMING, SurveyState.SURVEYING),
        *(SurveyState.PAUSING, SurveyState.PAUSED, SurveyState.STOPPING),
    }
)
ENDED = frozenset([SurveyState.FINISHED, SurveyState.STOPPED, SurveyState.FAILED])
_LABELS = {
    SurveyState.IDLE: Message("IDLE"),
    SurveyState.CONFIGURED: Message("CONFIGURED"),
    SurveyState.CHECKING: Message("CHECKING"),
    SurveyState.HOMING: Message("HOMING"),
    SurveyState.SURVEYING: Message("SURVEYING"),
    SurveyState.PAUSED: Message("PAUSED"),
    SurveyState.STOPPING: Message("STOPPING"),
    SurveyState.FINISHED: Message("FINISHED"),
    SurveyState.STOPPED: Message("STOPPED"),
    SurveyState.FAILED: Message("FAILED"),
    SurveyState.PAUSING: Message("PAUSING"),
}
