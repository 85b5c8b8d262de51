"""NOW: the state of robot and survey as the window shows it, in the language of each browser."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.robot.condition import JobLevel, condition_of, left_of
from gpr20_operator.robot.events import CurrentPosition
from gpr20_operator.robot.notices import fault_notice
from gpr20_operator.robot.snapshot import (
    Snapshot,
    area_of,
    line_of,
    percent_of,
    progress_of,
    survey_name,
)
from gpr20_web.calls import Text, WebPage, sentence


def _at(place: CurrentPosition) -> Message:
    return Message("X {x_mm:.1f} mm, Y {y_mm:.1f} mm, {z_deg:.0f} deg", **vars(place))


class NowPage(WebPage):
    """The band, the job and what is wrong.

    Args:
        robot: Its name, where there are several; else empty.
    """

    words: Mapping[str, Message] = {
        "title": Message("Survey"),
        "stored": Message("Stored"),
        "traces": Message("{stored} of {planned} traces", stored="{stored}", planned="{planned}"),
        "survey": Message("Survey"),
        "area": Message("Area"),
        "line": Message("Line"),
        "position": Message("Antennas at"),
        "result": Message("Result"),
        "details": Message("Details"),
        "simulated": Message("SIMULATED"),
    }

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._snapshot: Optional[Snapshot] = None
        self._named: Tuple[str, str] = ("", "")

    def on_event(self, event: object) -> None:
        """Follow the name of the survey."""
        if isinstance(event, SurveyDescribed):
            self._named = survey_name(event.text)

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now."""
        self._snapshot = snapshot

    def live(self, text: Text) -> Mapping[str, Any]:
        """Return band, job and fault."""
        snapshot = self._snapshot
        if snapshot is None:
            return {}
        band, state, fault = self._band(snapshot, text), snapshot.state, None
        if state is not None and state.is_fault:
            card = fault_notice(state)
            fault = {
                **{"title": text(card.title), "details": list(card.details)},
                **{"text": sentence(text, card.text), "first": sentence(text, card.first)},
                "then": sentence(text, card.then),
            }
        return {
            "robot": {
                "name": self._robot,
                "level": band["level"],
                "simulated": snapshot.simulated,
            },
            "band": band,
            "job": self._job(snapshot, text),
            "fault": fault,
        }

    @staticmethod
    def _band(snapshot: Snapshot, text: Text) -> Mapping[str, Any]:
        condition, left = condition_of(snapshot), left_of(snapshot)
        shows_left = condition.level in (JobLevel.WORKING, JobLevel.PAUSED)
        return {
            "level": condition.level.value,
            "title": text(condition.title),
            "message": sentence(text, condition.message),
            "asked": sentence(text, condition.asked),
            "left": sentence(text, left if shows_left else None),
        }

    def _job(self, snapshot: Snapshot, text: Text) -> Mapping[str, Any]:
        progress, parameters = progress_of(snapshot), snapshot.job_parameters
        state, place = snapshot.state, snapshot.current
        survey_id, name = self._named
        known = state is not None and state.survey_id == survey_id
        return {
            "running": snapshot.running,
            "paused": snapshot.paused,
            "survey": state.survey_id if state is not None else "",
            "name": name if known else "",
            "percent": percent_of(snapshot),
            "stored": None if progress is None else progress.visited_points,
            "planned": None if progress is None else progress.total_points,
            "line": sentence(text, line_of(snapshot)),
            "area": "" if parameters is None else text(area_of(parameters)),
            "place": None if place is None else text(_at(place)),
        }
