"""The states of a survey and the transitions between them."""

from __future__ import annotations

import enum
from typing import Dict, FrozenSet

from gpr20_common.errors import Gpr20Error
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
        return LABELS[self]


LABELS: Dict[SurveyState, Message] = {
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
RUNNING = frozenset(
    [
        SurveyState.CHECKING,
        SurveyState.HOMING,
        SurveyState.SURVEYING,
        SurveyState.PAUSING,
        SurveyState.PAUSED,
        SurveyState.STOPPING,
    ]
)
ENDED = frozenset([SurveyState.FINISHED, SurveyState.STOPPED, SurveyState.FAILED])

_S = SurveyState
TRANSITIONS: Dict[SurveyState, FrozenSet[SurveyState]] = {
    # From rest to CHECKING without new parameters: a survey is resumed from its folder.
    _S.IDLE: frozenset([_S.CONFIGURED, _S.CHECKING]),
    _S.CONFIGURED: frozenset([_S.CONFIGURED, _S.CHECKING]),
    # To FINISHED: a node was lost when everything was stored already.
    _S.CHECKING: frozenset([_S.HOMING, _S.PAUSED, _S.STOPPING, _S.FINISHED, _S.FAILED]),
    _S.HOMING: frozenset([_S.CHECKING, _S.SURVEYING, _S.PAUSED, _S.STOPPING, _S.FAILED]),
    # Back to CHECKING: a node was lost; the survey continues by itself when it is back.
    _S.SURVEYING: frozenset(
        [_S.CHECKING, _S.PAUSING, _S.PAUSED, _S.STOPPING, _S.FINISHED, _S.FAILED]
    ),
    _S.PAUSING: frozenset([_S.CHECKING, _S.PAUSED, _S.STOPPING, _S.FINISHED, _S.FAILED]),
    _S.PAUSED: frozenset([_S.CHECKING, _S.STOPPING, _S.FAILED]),
    _S.STOPPING: frozenset([_S.STOPPED, _S.FAILED]),
    _S.FINISHED: frozenset([_S.CONFIGURED, _S.CHECKING]),
    _S.STOPPED: frozenset([_S.CONFIGURED, _S.CHECKING]),
    _S.FAILED: frozenset([_S.CONFIGURED, _S.CHECKING]),
}


class TransitionError(Gpr20Error, RuntimeError):
    """A state cannot follow another."""


def check_transition(before: SurveyState, after: SurveyState) -> None:
    """Refuse a transition between two states that does not exist.

    Raises:
        TransitionError: The table does not hold it.
    """
    if after not in TRANSITIONS[before]:
        raise TransitionError(
            Message(
                "a survey that is {before} cannot become {after}",
                before=before.label,
                after=after.label,
            )
        )
