"""Main control, axes and web page: their topics as events, and requests without waiting."""

from __future__ import annotations

import dataclasses
import json
import math
import threading
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import VERSIONS_DIFFER
from gpr20_common.high.answers import message_from, record_of
from gpr20_common.high.raw_message import connection_header
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_doctor.high.graph import descriptions, node_healths
from gpr20_doctor.mid.node_health import WEB
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop
from gpr20_msgs import msg, srv
from gpr20_msgs.msg import RemoteControl, WebStatus
from gpr20_operator.high.robot_stop import RobotStop
from gpr20_operator.high.ros_events import CONTROL_SILENT, RosEvents, in_background, no_answer
from gpr20_operator.robot.events import (
    Answer,
    Configured,
    ControlState,
    CurrentPosition,
    MasterAnswered,
    Progress,
    Replay,
    Request,
    RobotDescribed,
    Senders,
    ServiceActivity,
    StartPlan,
    TargetPosition,
)
from gpr20_operator.robot.remote_control import RemoteArmed, WebStatusReported
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.annotation import Site, from_fields
from gpr20_survey.plan.robot_description import ANALYZER, robot_config
from gpr20_survey.plan.survey_parameters import (
    DEFAULT_POLARIZATIONS_DEG,
    SurveyParameters,
    SurveySettings,
)
from gpr20_survey.plan.survey_state import SurveyState

WINDOW = "user_interface"
ANSWER_TIMEOUT_S = 10.0
# An axis reports itself at 10 Hz at rest and at 50 Hz while it moves: fewer are enough for what
# people see, and for a STOP, which is confirmed within 1 s.
AXIS_PERIOD_S = 0.2
# Checks of the devices come before the answer, and homing may: at the lowest speed an axis
# of 800 mm takes 800 s. The survey can be stopped meanwhile.
START_TIMEOUT_S = 1200.0
REPLAYS = {
    msg.Replay.PLAYING: Replay(),
    msg.Replay.PAUSED: Replay(Message("REPLAY PAUSED")),
    msg.Replay.ENDED: Replay(Message("REPLAY ENDED")),
}
LIMITS_UNKNOWN = Message("the limits of the axes are not known").with_fault(VERSIONS_DIFFER)
WITHDRAWN = Message("the survey was not started: STOP was pressed, or the permission ended")


class ControlClient(RosEvents):
    """See `SurveyControl`; passes everything about the main control and the axes to a listener."""

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._set_parameters = ServiceClient("set_survey_parameters", srv.SetSurveyParameters)
        self._start = ServiceClient("start_survey", srv.StartSurvey)
        self._stop = RobotStop(self._emit)
        # A start that was asked for with another number is not asked for any further.
        self._withdrawals = 0
        self._pause = ServiceClient("pause_survey", srv.Command)
        self._resume = ServiceClient("resume_survey", srv.ResumeSurvey)
        self._checking_master = threading.Lock()
        # The last report of each axis that was passed on: whether it moved, and when [s].
        self._reports: Dict[AxisId, Tuple[bool, float]] = {}

    def close(self) -> None:
        """Call the listener no more, and repeat no request."""
        self._stop.forget()
        super().close()

    def listen(self) -> None:
        """Subscribe to state and progress of the survey, and to what is done for maintenance."""
        self._subscribe("control_status", msg.ControlStatus, control_state)
        self._subscribe("replay", msg.Replay, lambda one: REPLAYS.get(one.state))
        self._subscribe("control_survey_data", msg.SurveyData, _progress)
        self._subscribe("service_status", msg.ServiceStatus, _activity)
        self._subscribe("robot_configuration", msg.RobotConfiguration, robot_described)

    def _watched_topics(self) -> List[rospy.Subscriber]:
        """Subscribe to motion, position, endstops and health of the robot."""
        topics: List[Any] = [
            ("control_current_coordinate", msg.Coordinates, partial(record_of, CurrentPosition), 1),
            ("control_target_coordinate", msg.Coordinates, _target, 1),
            ("survey_parameters", msg.SurveyParameters, parameters, None),
        ]
        for axis in AxisId:
            topic = f"{axis.value}_axis/current_coord"
            topics.append((topic, msg.CurrentCoordinate, partial(self._measured, axis), 1))
            if axis is not AxisId.Z:
                topics.append((f"{axis.value}_axis/endstop", Bool, partial(_endstop, axis), 10))
        health = rospy.Subscriber("/diagnostics", DiagnosticArray, self._diagnosed, queue_size=20)
        return [health, *(self._subscriber(*one) for one in topics)]

    def start_survey(self, plan: StartPlan) -> None:
        """See `SurveyControl`."""
        self._stop.forget()
        withdrawals = self._withdrawals
        self._ask(Request.START, lambda: self._ask_start(plan, withdrawals))

    def stop(self) -> None:
        """Ask every axis and the main control to stop, at the same time; the answers are events."""
        self.withdraw_start()
        self._stop.press()

    def withdraw_start(self) -> None:
        """See `SurveyControl`."""
        self._withdrawals += 1

    def pause_survey(self) -> None:
        """See `SurveyControl`."""
        self._ask(Request.PAUSE, lambda: self._pause.call(ANSWER_TIMEOUT_S))

    def resume_survey(
        self, survey_id: str = "", accept_analyzer: str = "", accept_zeros: bool = False
    ) -> None:
        """See `SurveyControl`."""
        self._stop.forget()
        fields = {"accept_analyzer": accept_analyzer, "accept_zeros": accept_zeros}
        self._ask(
            Request.RESUME,
            lambda: self._resume.call(START_TIMEOUT_S, survey=survey_id, **fields),
        )

    def check_master(self) -> None:
        """See `SurveyControl`."""
        # A master that hangs must not collect one thread per call.
        if self._checking_master.acquire(blocking=False):
            in_background(self._check_master)

    def _check_master(self) -> None:
        try:
            self._stop.remember()
            self._emit(MasterAnswered(True))
        except (rosgraph.MasterException, OSError):
            self._emit(MasterAnswered(False))
        finally:
            self._checking_master.release()

    def _ask_start(self, plan: StartPlan, withdrawals: int) -> Any:
        """Return the answer; None if the request was withdrawn."""
        fields = plan_fields(plan)
        accepted = self._set_parameters.call(ANSWER_TIMEOUT_S, parameters=fields.pop("parameters"))
        if not accepted.success:
            return accepted
        if withdrawals != self._withdrawals:
            return None
        return self._start.call(START_TIMEOUT_S, plan_id=accepted.plan_id, **fields)

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

    def _measured(self, axis: AxisId, message: msg.CurrentCoordinate) -> Optional[AxisReport]:
        now_s = self._clock.now_s()
        moved, reported_s = self._reports.get(axis, (False, -math.inf))
        # A motion that begins is passed on at once, however short it is.
        begins = message.moving and not moved
        if now_s - reported_s < AXIS_PERIOD_S and not begins:
            return None
        self._reports[axis] = message.moving, now_s
        return record_of(AxisReport, message, axis=axis)

    def _diagnosed(self, message: DiagnosticArray) -> None:
        # Every node of the graph publishes there about itself: others are no surprise.
        if self._senders.takes(connection_header(message)["callerid"]):
            for health in node_healths(message, self._senders.namespace):
                self._emit(health)


def _progress(message: msg.SurveyData) -> Progress:
    return record_of(Progress, message, remaining_s=message.remaining_time.to_sec())


def _activity(message: msg.ServiceStatus) -> ServiceActivity:
    return ServiceActivity(message_from(message) if message.busy else None)


def _endstop(axis: AxisId, message: Bool) -> Endstop:
    return Endstop(axis, message.data)


def _target(message: msg.Coordinates) -> Optional[TargetPosition]:
    place = record_of(TargetPosition, message)
    # All three are -1 while no survey runs.
    return None if place == TargetPosition(-1.0, -1.0, -1.0) else place


def plan_fields(plan: StartPlan) -> Dict[str, Any]:
    """Return the fields of messages and services that carry what START measures."""
    return {
        "parameters": msg.SurveyParameters(**dataclasses.asdict(plan.parameters)),
        "annotation": msg.Annotation(**plan.annotation.fields()),
        "refines": plan.refines,
        "permittivity": plan.permittivity,
    }


def parameters(message: msg.SurveyParameters) -> SurveyParameters:
    """Convert `survey_parameters`."""
    rotations_deg = tuple(message.polarizations_deg) or DEFAULT_POLARIZATIONS_DEG
    return record_of(SurveyParameters, message, polarizations_deg=rotations_deg)


def control_state(message: msg.ControlStatus) -> ControlState:
    """Convert `control_status`."""
    code, end = SurveyState(message.code), SurveyState(message.end)
    return ControlState(code, message_from(message), message.survey_id, message.simulated, end)


def robot_described(message: msg.RobotConfiguration) -> RobotDescribed:
    """Convert `robot_configuration`."""
    nodes = descriptions(message)
    if not message.known:
        return RobotDescribed(None, message_from(message), nodes)
    try:
        config = robot_config(nodes)
        # Another version of the node may have fields that this one does not know.
        own = nodes["main_control"].configuration
        settings = record_from(SurveySettings, own, "main_control", others=True)
        site = record_from(Site, json.loads(message.site_json), "site", others=True)
        address = str(nodes[ANALYZER].configuration.get("address", ""))
    except (Gpr20Error, ValueError, KeyError, TypeError) as error:
        return RobotDescribed(None, LIMITS_UNKNOWN.with_details(error))
    return RobotDescribed(Configured(config, settings, site, address), nodes=nodes)


class RemoteControlClient(RosEvents):
    """The web page's side: what the window of its robot allows, and nobody else.

    Args:
        listener: Gets the events.
        namespace: Of the robot, with slashes at both ends or alone.
    """

    def __init__(self, listener: Callable[[Any], None], namespace: str) -> None:
        super().__init__(listener, Senders(namespace, nodes=(WINDOW,)))

    def listen(self) -> None:
        self._subscribe("remote_control", RemoteControl, remote_armed)


class WebPageClient(RosEvents):
    """The window's side: what the web page says of itself, and what the window allows it.

    Args:
        listener: Gets the events.
        namespace: Of the robot, with slashes at both ends or alone.
    """

    def __init__(self, listener: Callable[[Any], None], namespace: str) -> None:
        super().__init__(listener, Senders(namespace, nodes=(WEB,)))
        self._remote: Optional[rospy.Publisher] = None

    def listen(self) -> None:
        self._remote = rospy.Publisher("remote_control", RemoteControl, queue_size=10, latch=True)
        self._subscribe("web_status", WebStatus, lambda one: record_of(WebStatusReported, one))

    def send(self, event: RemoteArmed) -> None:
        """Publish what is allowed; not when this node ends, which allows nothing any more."""
        if self._remote is not None and not rospy.is_shutdown():
            self._remote.publish(remote_message(event))


def remote_message(event: RemoteArmed) -> RemoteControl:
    """Return the message of an event."""
    fields = {} if event.plan is None else {"has_plan": True, **plan_fields(event.plan)}
    remaining = rospy.Duration.from_sec(event.remaining_s)
    return RemoteControl(armed=event.armed, remaining=remaining, **fields)


def remote_armed(message: RemoteControl) -> RemoteArmed:
    """Convert `remote_control`."""
    remaining_s = message.remaining.to_sec()
    if not message.has_plan:
        return RemoteArmed(message.armed, remaining_s)
    plan = StartPlan(
        parameters(message.parameters),
        from_fields(message.annotation),
        message.refines,
        message.permittivity,
    )
    return RemoteArmed(message.armed, remaining_s, plan)
