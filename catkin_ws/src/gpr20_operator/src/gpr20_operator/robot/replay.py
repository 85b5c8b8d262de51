"""A replay as clients see it: which survey is shown, and how far it is."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message
from gpr20_survey.plan.survey_state import ENDED, SurveyState
from gpr20_survey.trace.utc_time import moment_text


class ReplayPhase(enum.IntEnum):
    """What a replay does; the values are those of gpr20_msgs/Replay."""

    PLAYING = 0
    PAUSED = 1
    ENDED = 2


@dataclass(frozen=True)
class PlayerLink:
    """Event: whether a player of recordings is connected; once a second."""

    connected: bool


@dataclass(frozen=True)
class Replay:
    """The last message of `replay`, and what is known besides; texts are empty if not known.

    Attributes:
        started: Start of the survey, ISO 8601, UTC.
        rate: How many times faster than it was recorded; 0: its player does not report it.
        connected: Whether its player is; None: none has been yet.
        state: The last state of the recorded survey; None before the first.
    """

    survey_id: str = ""
    started: str = ""
    folder: str = ""
    phase: ReplayPhase = ReplayPhase.PLAYING
    rate: float = 0.0
    connected: Optional[bool] = True
    state: Optional[SurveyState] = None

    @property
    def survey(self) -> Message:
        """The survey, for a sentence."""
        place = self.folder or self.survey_id[:8]
        if len(self.started) >= 16:
            time = moment_text(self.started[:16])
            return Message("Survey of {time} UTC, {folder}", time=time, folder=place)
        return Message("Survey {folder}", folder=place) if place else Message("Recorded survey")

    @property
    def ended(self) -> bool:
        """Whether nothing more will come."""
        return self.connected is False or self.phase is ReplayPhase.ENDED

    @property
    def paused(self) -> bool:
        """Whether it is paused and can continue."""
        return not self.ended and self.phase is ReplayPhase.PAUSED

    @property
    def can_pause(self) -> bool:
        """Whether its player takes requests: `rosbag play` takes none."""
        return not self.ended and self.rate > 0.0

    @property
    def title(self) -> Message:
        """What is shown where the state of a robot would be."""
        if self.ended:
            return Message("REPLAY ENDED")
        return Message("REPLAY PAUSED") if self.paused else Message("REPLAY")

    @property
    def message(self) -> Message:
        """The survey, and its state or how it ended."""
        if self.connected is None:
            return Message("Waiting for a recording.")
        if self.state is None:
            return self.survey
        if self.ended and self.state not in ENDED:
            return Message(
                "{state}, and the recording does not contain the survey's end. {survey}",
                state=self.state.label,
                survey=self.survey,
            )
        return Message("{state}. {survey}", state=self.state.label, survey=self.survey)
