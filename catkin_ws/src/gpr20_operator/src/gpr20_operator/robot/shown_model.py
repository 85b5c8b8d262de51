"""The model of what the window shows: a robot, or a replay where there is no robot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_operator.robot.events import (
    ControlParameters,
    ControlState,
    CurrentPosition,
    MeasuredHeight,
    Progress,
    Request,
    TargetPosition,
)
from gpr20_operator.robot.health import SIMULATOR, HealthReport
from gpr20_operator.robot.message_source import MessageSources, Received, SourceGone
from gpr20_operator.robot.replay import ReplayMark, ReplayView
from gpr20_operator.robot.service_events import AxisMeasured, ServiceActivity
from gpr20_operator.robot.survey_model import Refusal, Snapshot, SurveyModel
from gpr20_survey.plan.survey_state import RUNNING

# A robot that was heard within this time [s] is there, whatever is replayed beside it. Longer than
# any of the times after which its messages are stale.
ROBOT_LIMIT_S = 10.0
# What the main control alone publishes.
CONTROL_EVENTS = (
    ControlState,
    Progress,
    CurrentPosition,
    TargetPosition,
    ControlParameters,
    ServiceActivity,
)
ROBOT_EVENTS = (*CONTROL_EVENTS, MeasuredHeight)


class StoppedClock(Clock):
    """Time that does not pass: nothing that was recorded goes stale."""

    def now_s(self) -> float:
        """Return the only moment [s]."""
        return 0.0


class _Replay:
    """One replay."""

    def __init__(self) -> None:
        self.model = SurveyModel(StoppedClock())
        self.mark = ReplayMark()
        self.survey_id = ""
        self.gone = False

    def snapshot(self) -> Snapshot:
        snapshot = self.model.snapshot()
        state = None if snapshot.state is None else replace(snapshot.state, replay=True)
        view = ReplayView(self.mark, self.gone, None if state is None else state.code)
        # Nodes that the recording says nothing about are not offline.
        nodes = tuple(node for node in snapshot.health.nodes if node.level is not HealthLevel.STALE)
        return replace(snapshot, state=state, replay=view, alarm=None, health=HealthReport(nodes))


class ShownModel:
    """Takes events, gives snapshots of the robot or of a replay. Belongs to one thread.

    A robot always comes first. A replay is shown only if no robot was heard within ROBOT_LIMIT_S,
    none was left moving or with a survey in progress, and no request to one is pending: then there
    is nothing to stop.

    Args:
        clock: Measures how long the robot has been silent.
        sources: Tells robots from replays.
        robot: The model of the robot.
    """

    def __init__(self, clock: Clock, sources: MessageSources, robot: SurveyModel) -> None:
        self._clock = clock
        self._sources = sources
        self._robot = robot
        self._robot_heard_s: Dict[str, float] = {}
        # The last events of each node of the robot: one of them may turn out to be a replay.
        self._last: Dict[str, Dict[Tuple[Any, ...], object]] = {}
        self._replays: Dict[str, _Replay] = {}

    @property
    def shows_replay(self) -> bool:
        """Whether a replay is shown."""
        return bool(self._replays) and not self._robot_is_there()

    def request_sent(self, request: Request) -> None:
        """Note that a request was sent to the main control and is not answered yet."""
        self._robot.request_sent(request)

    def handle(self, event: object) -> Optional[Refusal]:
        """Take an event; return the request that it shows to have failed."""
        if isinstance(event, SourceGone):
            self._note_gone(event.source)
            return None
        if not isinstance(event, Received):
            return self._robot.handle(event)
        source, content = event.source, event.event
        if isinstance(content, ReplayMark):
            self._note_mark(source, content)
            return None
        if self._sources.is_replay(source):
            self._replay_of(source, _survey_id(content)).model.handle(content)
            return None
        return self._take_robot(source, content)

    def is_shown(self, event: object) -> bool:
        """Return whether an event that was handled is about what is shown."""
        if not isinstance(event, Received):
            return True
        return self._sources.is_replay(event.source) == self.shows_replay

    def snapshot(self) -> Snapshot:
        """Return what is known now."""
        if not self.shows_replay:
            return self._robot.snapshot()
        playing = [one for one in self._replays.values() if not one.gone]
        return (playing or list(self._replays.values()))[-1].snapshot()

    def _robot_is_there(self) -> bool:
        now_s = self._clock.now_s()
        if any(now_s - heard_s <= ROBOT_LIMIT_S for heard_s in self._robot_heard_s.values()):
            return True
        robot = self._robot.snapshot()
        if robot.pending or robot.moving:
            return True
        return robot.state is not None and robot.state.code in RUNNING

    def _is_strange(self, source: str, event: object) -> bool:
        """Return whether a node speaks for an axis, or for the main control that there is."""
        if isinstance(event, AxisMeasured):
            return source != self._sources.axis_driver(event.axis)
        control = self._sources.main_control
        known = control in self._robot_heard_s
        return known and source != control and isinstance(event, CONTROL_EVENTS)

    def _make_robot_again(self) -> None:
        pending = self._robot.snapshot().pending
        self._robot = SurveyModel(self._clock)
        for source, events in self._last.items():
            for event in events.values():
                if not self._is_strange(source, event):
                    self._robot.handle(event)
        for request in pending:
            self._robot.request_sent(request)

    def _take_robot(self, source: str, event: object) -> Optional[Refusal]:
        if isinstance(event, NodeHealth) and event.name not in (*EXPECTED_NODES, SIMULATOR):
            return None
        if isinstance(event, (*ROBOT_EVENTS, NodeHealth, AxisMeasured)):
            self._last.setdefault(source, {})[_kind(event)] = event
        if self._is_strange(source, event):
            return None
        is_news = source not in self._robot_heard_s
        self._robot_heard_s[source] = self._clock.now_s()
        if is_news and source == self._sources.main_control:
            # What others have said in its name does not count any more.
            self._make_robot_again()
        return self._robot.handle(event)

    def _note_mark(self, source: str, mark: ReplayMark) -> None:
        if source == self._sources.main_control:
            return
        if self._sources.note_mark(source):
            self._take_from_robot(source)
        self._replay_of(source, mark.survey_id).mark = mark

    def _take_from_robot(self, source: str) -> None:
        """Move what a node has sent from the robot to its replay."""
        self._robot_heard_s.pop(source, None)
        moved = self._last.pop(source, {})
        if not moved:
            return
        self._make_robot_again()
        replay = self._replay_of(source)
        for event in moved.values():
            replay.model.handle(event)
            replay.survey_id = _survey_id(event) or replay.survey_id

    def _replay_of(self, source: str, survey_id: str = "") -> _Replay:
        """Return the replay of a node; another survey begins another one.

        Messages that were in flight when the node ended still belong to its replay.
        """
        replay = self._replays.get(source)
        if replay is None or (survey_id and replay.survey_id not in ("", survey_id)):
            # The last one is shown.
            self._replays = {name: one for name, one in self._replays.items() if not one.gone}
            self._replays.pop(source, None)
            replay = self._replays[source] = _Replay()
        replay.survey_id = survey_id or replay.survey_id
        replay.gone = False
        return replay

    def _note_gone(self, source: str) -> None:
        if source in self._replays:
            self._replays[source].gone = True


def _survey_id(event: object) -> str:
    return event.survey_id if isinstance(event, (ControlState, Progress)) else ""


def _kind(event: object) -> Tuple[Any, ...]:
    if isinstance(event, NodeHealth):
        return NodeHealth, event.name
    return (AxisMeasured, event.axis) if isinstance(event, AxisMeasured) else (type(event),)
