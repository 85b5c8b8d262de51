"""The model of a client that shows a replay, in place of the model of a robot."""

from __future__ import annotations

from dataclasses import replace
from typing import Optional

from gpr20_common.low.clock import Clock
from gpr20_doctor.mid.node_health import HealthLevel
from gpr20_operator.robot.events import ControlState, Progress, Request
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.replay import PlayerLink, ReplayMark, ReplayView
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.survey_model import SurveyModel


class StoppedClock(Clock):
    """Time that does not pass: nothing that was recorded goes stale."""

    def now_s(self) -> float:
        """Return the only moment [s]."""
        return 0.0


class ReplayModel:
    """Takes what a player sends, gives snapshots of a replay. Belongs to one thread."""

    def __init__(self) -> None:
        self.survey_id = ""
        self._recorded = SurveyModel(StoppedClock())
        self._mark = ReplayMark()
        self._connected: Optional[bool] = None

    def request_sent(self, _request: Request) -> None:
        """Take no request: there is nobody to ask."""

    def handle(self, event: object) -> None:
        """Take an event; another survey begins another replay."""
        if isinstance(event, PlayerLink):
            self._connected = event.connected
            return
        if isinstance(event, (ReplayMark, ControlState, Progress)):
            self._note_survey(event.survey_id)
        if isinstance(event, ReplayMark):
            self._mark = event
        self._recorded.handle(event)

    def snapshot(self) -> Snapshot:
        """Return what is known now."""
        shown = self._recorded.snapshot()
        # Nodes that the recording says nothing about are not offline.
        nodes = tuple(node for node in shown.health.nodes if node.level is not HealthLevel.STALE)
        view = ReplayView(self._mark, self._connected, shown.code)
        return replace(shown, replay=view, health=HealthReport(nodes))

    def _note_survey(self, survey_id: str) -> None:
        if survey_id and self.survey_id not in ("", survey_id):
            self._recorded, self._mark = SurveyModel(StoppedClock()), ReplayMark()
            self._connected = True
        self.survey_id = survey_id or self.survey_id
        # What was in flight when the player ended does not begin its replay again.
        self._connected = self._connected is not False
