"""What MAP and RADAR say above a picture that is not of the survey that runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message, verbatim
from gpr20_survey.plan.imported import IMPORTED
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.mid.replay import ReplayMark


@dataclass(frozen=True)
class ShownBand:
    """The band above the picture.

    Attributes:
        text: Which survey is shown.
        can_return: Whether there is something live to go back to.
        replay: Whether it is a replay.
    """

    text: Message
    can_return: bool
    replay: bool = False


def past_band(folder: str, survey: Optional[SurveySummary], another_runs: bool) -> ShownBand:
    """Return the band of a past survey.

    Args:
        folder: The survey's folder.
        survey: What the list says about it; None if it is not in the list.
        another_runs: Whether a survey is running meanwhile.
    """
    name = verbatim(folder)
    if survey is not None:
        called = survey.name or survey.survey_id[:8]
        name = Message("{time}, {name}", time=survey.local_time(), name=called)
    if another_runs:
        return ShownBand(Message("NOT THE RUNNING SURVEY: {name}", name=name), True)
    if survey is not None and survey.outcome == IMPORTED:
        return ShownBand(Message("IMPORTED SURVEY: {name}", name=name), True)
    return ShownBand(Message("PAST SURVEY: {name}", name=name), True)


def replay_band(mark: ReplayMark) -> ShownBand:
    """Return the band of a replay, beside which there is no robot."""
    return ShownBand(Message("REPLAY: {name}", name=mark.survey), False, replay=True)
