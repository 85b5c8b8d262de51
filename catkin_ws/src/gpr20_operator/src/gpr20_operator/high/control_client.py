"""The main control's topics and services as events of this package."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Range
from std_msgs.msg import Bool

from gpr20_common.high.answers import message_from
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.high.node_reports import axis_report, height_m, node_healths
from gpr20_doctor.mid.node_health import EXPECTED_NODES
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop
from gpr20_msgs.msg import (
    ControlStatus,
    Coordinates,
    CurrentCoordinate,
    Replay,
    RobotConfiguration,
    ServiceStatus,
    SurveyData,
)
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
from gpr20_msgs.srv import Command, ResumeSurvey, SetSurveyParameters, StartSurvey
from gpr20_operator.high import conversions
from gpr20_operator.high.robot_stop import RobotStop
from gpr20_operator.high.ros_events import (
    CONTROL_SILENT,
    RosEvents,
    WhileWatched,
    in_background,
    no_answer,
)
from gpr20_operator.robot.events import (
    Accepted,
    Answer,
    ControlState,
    CurrentPosition,
    MasterAnswered,
    MeasuredHeight,
    PlayerLink,
    Request,
    Senders,
    ServiceActivity,
    TargetPosition,
)
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters

SET_TIMEOUT_S = 10.0
PAUSE_TIMEOUT_S = 10.0
# An axis reports itself at 10 Hz at rest and at 50 Hz while it moves: fewer are enough for what
# people see, and for a STOP, which is confirmed within 1 s.
AXIS_PERIOD_S = 0.2
# Checks of the devices come before the answer, and homing may: at the lowest speed an axis
# of 800 mm takes 800 s. The survey can be stopped meanwhile.
START_TIMEOUT_S = 1200.0
# Between two looks whether a player is connected [s].
PLAYER_PERIOD_S = 1.0
WITHDRAWN = Message("the survey was not started: STOP was pressed, or the permission ended")


class ControlClient(RosEvents):
    """Passes everything about the main control to a listener; asks it without waiting."""

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._set_parameters = ServiceClient("set_survey_parameters", SetSurveyParameters)
        self._start = ServiceClient("start_survey", StartSurvey)
        self._stop = RobotStop(self._emit)
        # A start that was asked for with another number is not asked for any further.
        self._withdrawals = 0
        self._pause = ServiceClient("pause_survey", Command)
        self._resume = ServiceClient("resume_survey", ResumeSurvey)
        self._pause_replay = ServiceClient("pause", Command)
        self._continue_replay = ServiceClient("continue", Command)
        self._player: Optional[Periodic] = None
        self._player_seen = False
        self._checking_master = threading.Lock()
        self._clock = Clock()
        # The last report of each axis that was passed on: whether it moved, and when [s].
        self._reports: Dict[AxisId, Tuple[bool, float]] = {}
        self._robot = WhileWatched(self._robot_subscriptions)
        self._endstops = WhileWatched(self._endstop_subscriptions)

    def close(self) -> None:
        """Call the listener no more, and repeat no request."""
        self._stop.forget()
        self.set_watched(False)
        self.watch_endstops(False)
        if self._player is not None:
            self._player.stop()
        super().close()

    def listen(self) -> None:
        """Subscribe to state and progress of the survey, and to what is done for maintenance."""
        self._subscribe("control_status", ControlStatus, self._state, None)
        self._subscribe("replay", Replay, conversions.replay, None)
        if self._senders.replay:
            # The recording of an imported survey has no status.
            topics = tuple(self._subscribers)
            self._player = Periodic(PLAYER_PERIOD_S, lambda: self._check_player(topics))
        self._subscribe("control_survey_data", SurveyData, conversions.progress, None)
        self._subscribe("service_status", ServiceStatus, _activity, None)
        self._subscribe(
            "robot_configuration", RobotConfiguration, conversions.robot_described, None
        )

    def set_watched(self, watched: bool) -> None:
        """Follow motion, position, height and health of the robot, or no longer."""
        self._robot.set_watched(watched)

    def watch_endstops(self, watched: bool) -> None:
        """Follow the endstops, or no longer: each message costs time."""
        self._endstops.set_watched(watched)

    def start_survey(
        self,
        parameters: SurveyParameters,
        annotation: Annotation = EMPTY,
        refines: str = "",
        permittivity: float = 0.0,
    ) -> None:
        """Ask to accept the parameters and to start; the answer is an event.

        Args:
            parameters: What to measure.
            annotation: What people add to the survey; empty fields become the robot's defaults.
            refines: Id of the survey that this one measures more finely; empty: none.
            permittivity: Relative permittivity of the ground; 0: not known.
        """
        added = {
            "annotation": conversions.annotation_message(annotation),
            "refines": refines,
            "permittivity": permittivity,
        }
        self._stop.forget()
        withdrawals = self._withdrawals
        self._ask(Request.START, lambda: self._ask_start(parameters, added, withdrawals))

    def stop(self) -> None:
        """Ask every axis and the main control to stop, at the same time; the answers are events."""
        self.withdraw_start()
        self._stop.press()

    def withdraw_start(self) -> None:
        """Keep a survey from starting whose parameters have not been accepted yet."""
        self._withdrawals += 1

    def pause_survey(self) -> None:
        """Ask to pause the survey; the answer is an event."""
        self._ask(Request.PAUSE, lambda: self._pause.call(PAUSE_TIMEOUT_S))

    def resume_survey(
        self, survey_id: str = "", accept_analyzer: str = "", accept_zeros: bool = False
    ) -> None:
        """Ask to resume the paused survey or the one named; the answer is an event.

        Args:
            survey_id: Id or folder; empty: the paused survey.
            accept_analyzer: Identity of another analyzer that the operator accepts.
            accept_zeros: Whether the operator accepts zeros of the axes that nothing proves.
        """
        self._stop.forget()
        fields = {"accept_analyzer": accept_analyzer, "accept_zeros": accept_zeros}
        self._ask(
            Request.RESUME,
            lambda: self._resume.call(START_TIMEOUT_S, survey=survey_id, **fields),
        )

    def set_replay_paused(self, paused: bool) -> None:
        """Ask the replay to pause or to continue; its next mark shows whether it did."""
        service = self._pause_replay if paused else self._continue_replay

        def ask() -> None:
            try:
                service.call(PAUSE_TIMEOUT_S)
            except ServiceUnavailableError as error:
                rospy.logwarn("the replay did not answer: %s", error)

        in_background(ask)

    def check_master(self) -> None:
        """Check that the master answers; the answer is an event."""
        # A master that hangs must not collect one thread per call.
        if self._checking_master.acquire(blocking=False):
            in_background(self._check_master)

    def _robot_subscriptions(self) -> List[rospy.Subscriber]:
        subscriber = self._subscriber
        return [
            *(
                subscriber(
                    f"{axis.value}_axis/current_coord",
                    *(CurrentCoordinate, partial(self._measured, axis), 1),
                )
                for axis in AxisId
            ),
            subscriber("control_current_coordinate", Coordinates, _position(CurrentPosition), 1),
            subscriber("control_target_coordinate", Coordinates, _position(TargetPosition), 1),
            subscriber("survey_parameters", SurveyParametersMessage, conversions.parameters, None),
            subscriber("measured_height", Range, lambda one: MeasuredHeight(height_m(one)), 1),
            self._diagnostics_subscriber(),
        ]

    def _endstop_subscriptions(self) -> List[rospy.Subscriber]:
        def endstop(axis: AxisId) -> rospy.Subscriber:
            topic = f"{axis.value}_axis/endstop"
            return self._subscriber(topic, Bool, lambda one: Endstop(axis, one.data), 10)

        return [endstop(axis) for axis in (AxisId.X, AxisId.Y)]

    def _diagnostics_subscriber(self) -> rospy.Subscriber:
        """Emit each report of a node of this robot on `/diagnostics`."""
        # Players put a prefix before the topics; behind it, a robot may have had a namespace.
        namespace = self._senders.namespace
        prefix, _, recorded = namespace.strip("/").partition("/")
        below = f"/{prefix}" if prefix and self._senders.replay else ""

        def received(message: DiagnosticArray) -> None:
            found = node_healths(message, namespace)
            if self._senders.replay and not found:
                # `rosbag play --prefix` changes the names of topics, not those in the messages.
                found = node_healths(message, recorded)
            for health in found:
                # Every node of the graph publishes there about itself: only who speaks for a node
                # of this robot is no such node.
                if self._takes(message, is_usual=health.name not in EXPECTED_NODES):
                    self._emit(health)

        return rospy.Subscriber(f"{below}/diagnostics", DiagnosticArray, received, queue_size=20)

    def _check_master(self) -> None:
        try:
            rosgraph.Master(rospy.get_name()).getPid()
            self._stop.remember()
            self._emit(MasterAnswered(True))
        except (rosgraph.MasterException, OSError):
            self._emit(MasterAnswered(False))
        finally:
            self._checking_master.release()

    def _ask_start(
        self, parameters: SurveyParameters, added: Dict[str, Any], withdrawals: int
    ) -> Any:
        """Return the answer; None if the request was withdrawn."""
        message = conversions.parameters_message(parameters)
        accepted = self._set_parameters.call(SET_TIMEOUT_S, parameters=message)
        if not accepted.success:
            return accepted
        if withdrawals != self._withdrawals:
            return None
        self._emit(Accepted(accepted.total_points, accepted.estimated_time.to_sec()))
        return self._start.call(START_TIMEOUT_S, plan_id=accepted.plan_id, **added)

    def _ask(self, request: Request, ask: Callable[[], Any]) -> None:
        def work() -> None:
            try:
                response = ask()
            except (ServiceUnavailableError, rospy.ROSException) as error:
                silent = no_answer(CONTROL_SILENT, error)
                self._emit(Answer(request, False, silent, contact=False))
                return
            if response is None:
                self._emit(Answer(request, False, WITHDRAWN))
                return
            survey_id = getattr(response, "survey_id", "")
            other = getattr(response, "other_analyzer", "")
            said = message_from(response)
            self._emit(Answer(request, response.success, said, survey_id, other))

        in_background(work)

    def _measured(self, axis: AxisId, message: CurrentCoordinate) -> Optional[AxisReport]:
        now_s = self._clock.now_s()
        moved, reported_s = self._reports.get(axis, (False, -math.inf))
        # A motion that begins is passed on at once, however short it is.
        begins = message.moving and not moved
        if now_s - reported_s < AXIS_PERIOD_S and not begins:
            return None
        self._reports[axis] = message.moving, now_s
        return axis_report(axis, message)

    def _state(self, message: ControlStatus) -> ControlState:
        return replace(conversions.control_state(message), replay=self._senders.replay)

    def _check_player(self, topics: Tuple[rospy.Subscriber, ...]) -> None:
        connected = any(one.get_num_connections() for one in topics)
        self._player_seen = self._player_seen or connected
        if self._player_seen:
            self._emit(PlayerLink(connected))


def _position(kind: Any) -> Callable[[Coordinates], Any]:
    return lambda one: kind(one.x_mm, one.y_mm, one.z_deg)


def _activity(message: ServiceStatus) -> ServiceActivity:
    return ServiceActivity(message_from(message) if message.busy else None)
