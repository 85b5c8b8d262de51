"""The main control's topics and services as events of this package."""

from __future__ import annotations

import threading
from typing import Any, Callable, Dict, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Range

from gpr20_common.high.connection_header import connection_header
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_common.sent_message import message_from
from gpr20_doctor.high.node_reports import node_healths
from gpr20_msgs.msg import (
    ControlStatus,
    Coordinates,
    Replay,
    RobotConfiguration,
    SurveyData,
)
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
from gpr20_msgs.srv import Command, ResumeSurvey, SetSurveyParameters, StartSurvey
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface import faults
from gpr20_user_interface.high import conversions
from gpr20_user_interface.high.master import MasterWatch
from gpr20_user_interface.high.replay_watch import ReplayWatch
from gpr20_user_interface.high.robot_travel import axis_limits
from gpr20_user_interface.high.ros_events import RosEvents, in_background
from gpr20_user_interface.mid.events import (
    Accepted,
    AnnotationDefaults,
    Answer,
    AxisLimits,
    Event,
    Request,
)
from gpr20_user_interface.mid.message_source import is_player

SET_TIMEOUT_S = 10.0
PAUSE_TIMEOUT_S = 10.0
# STOP must not wait for a main control that hangs: then it goes to the axes directly.
STOP_TIMEOUT_S = 2.0
# A STOP that was not answered is repeated: the survey would continue when the link is back.
STOP_RETRY_S = 2.0
STOP_RETRIES_S = 900.0
AXES = ("x", "y", "z")
# Checks of the devices come before the answer, and homing may: at the lowest speed an axis
# of 800 mm takes 800 s. The survey can be stopped meanwhile.
START_TIMEOUT_S = 1200.0


def main_control_name() -> str:
    """Return the full name of the robot's main control."""
    return str(rospy.resolve_name("main_control"))


class DirectServiceClient(ServiceClient):
    """Remembers the address of a service: STOP must work while the master is away."""

    def __init__(self, name: str, service_class: Any) -> None:
        # A STOP that arrives late is still wanted.
        super().__init__(name, service_class, discard_late=False)
        self._address = ""

    def remember(self) -> None:
        """Ask the master for the address; a service that is not there has its last one.

        Raises:
            OSError: The master does not answer.
            rosgraph.MasterException: Its answer makes no sense.
        """
        master = rosgraph.Master(rospy.get_name())
        try:
            self._address = master.lookupService(rospy.resolve_name(self.name))
        except rosgraph.MasterError:
            # There is no such service now.
            return

    def _look_up(self, attempt: int, limit_s: float) -> str:
        # After a failure the master is asked: the service may have another address now.
        if attempt == 0 and self._address:
            return self._address
        return super()._look_up(attempt, limit_s)


class ControlClient(RosEvents):
    """Passes everything about the main control to a listener; asks it without waiting."""

    def __init__(self, listener: Callable[[Event], None]) -> None:
        super().__init__(listener)
        self._set_parameters = ServiceClient("set_survey_parameters", SetSurveyParameters)
        self._start = ServiceClient("start_survey", StartSurvey)
        self._stop = DirectServiceClient("stop_survey", Command)
        self._pause = ServiceClient("pause_survey", Command)
        self._resume = ServiceClient("resume_survey", ResumeSurvey)
        self._axis_stops = {
            axis: DirectServiceClient(f"{axis}_axis/stop", Command) for axis in AXES
        }
        self._pause_replay = ServiceClient("replay/pause", Command)
        self._continue_replay = ServiceClient("replay/continue", Command)
        self._master = MasterWatch()
        self._watch = ReplayWatch(main_control_name(), self._emit)
        self._checking_master = threading.Lock()
        self._limits = AxisLimits(None)
        self._repeating_stop = threading.Lock()
        self._stop_obsolete = threading.Event()
        self._clock = Clock()

    def close(self) -> None:
        """Call the listener no more, and repeat no request."""
        self._stop_obsolete.set()
        self._watch.close()
        super().close()

    def listen(self) -> None:
        """Subscribe to state and progress of the survey."""
        self._subscribe_raw("replay", Replay, self._on_replay, None)
        self._subscribe_raw("control_status", ControlStatus, self._on_status, None)
        self._subscribe("control_survey_data", SurveyData, conversions.progress, None)
        self._subscribe_raw("robot_configuration", RobotConfiguration, self._on_robot, None)

    def listen_to_robot(self) -> None:
        """Subscribe to position, height and health of the robot."""
        subscribe = self._subscribe
        subscribe("control_current_coordinate", Coordinates, conversions.current_position, 1)
        subscribe("control_target_coordinate", Coordinates, conversions.target_position, 1)
        subscribe("survey_parameters", SurveyParametersMessage, conversions.parameters, None)
        subscribe("measured_height", Range, conversions.measured_height, 1)
        self._subscribe_raw("/diagnostics", DiagnosticArray, self._on_diagnostics, 20)

    def start_survey(
        self, parameters: SurveyParameters, annotation: Annotation = EMPTY, refines: str = ""
    ) -> None:
        """Ask to accept the parameters and to start; the answer is an event.

        Args:
            parameters: What to measure.
            annotation: What people add to the survey; empty fields become the robot's defaults.
            refines: Id of the survey that this one measures more finely; empty: none.
        """
        self._stop_obsolete.set()
        self._ask(Request.START, lambda: self._ask_start(parameters, annotation, refines))

    def stop_survey(self) -> None:
        """Ask to stop the survey, until the main control answers; the answer is an event."""
        self._stop_obsolete.clear()
        in_background(self._stop_until_answered)

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
        self._stop_obsolete.set()
        fields = {"accept_analyzer": accept_analyzer, "accept_zeros": accept_zeros}
        self._ask(
            Request.RESUME,
            lambda: self._resume.call(START_TIMEOUT_S, survey=survey_id, **fields),
        )

    def set_replay_paused(self, paused: bool) -> None:
        """Ask the replay to pause or to continue; its next mark shows whether it did."""
        service = self._pause_replay if paused else self._continue_replay
        in_background(lambda: _call_or_log(service))

    def check_master(self) -> None:
        """Check that the master answers; the answer is an event with the limits of the axes."""
        # A master that hangs must not collect one thread per call.
        if self._checking_master.acquire(blocking=False):
            in_background(self._check_master)

    def _check_master(self) -> None:
        try:
            self._master.check()
            for service in (self._stop, *self._axis_stops.values()):
                service.remember()
            self._emit(self._limits)
        except (rosgraph.MasterException, OSError) as error:
            reason = Message("the ROS master does not answer", details=error)
            reason = reason.with_fault(faults.MASTER_LOST)
            self._emit(AxisLimits(None, reason, master_alive=False))
        finally:
            self._checking_master.release()

    def _on_robot(self, message: RobotConfiguration) -> None:
        limits = axis_limits(message)
        self._emit_received(message, limits)
        if is_player(connection_header(message)["callerid"]):
            return
        self._limits = limits
        if limits.defaults is not None:
            self._emit(AnnotationDefaults(limits.defaults.site.annotation))

    def _ask_start(self, parameters: SurveyParameters, annotation: Annotation, refines: str) -> Any:
        message = conversions.parameters_message(parameters)
        accepted = self._set_parameters.call(SET_TIMEOUT_S, parameters=message)
        if not accepted.success:
            return accepted
        self._emit(Accepted(accepted.total_points, accepted.estimated_time.to_sec()))
        note = conversions.annotation_message(annotation)
        return self._start.call(START_TIMEOUT_S, annotation=note, refines=refines)

    def _stop_until_answered(self) -> None:
        try:
            answer = _answer_from(Request.STOP, self._stop.call(STOP_TIMEOUT_S))
        except ServiceUnavailableError as error:
            self._stop_directly(_no_answer(error))
            self._repeat_stop()
            return
        if answer.success:
            self._emit(answer)
        else:
            # A main control that was restarted does not know that an axis still moves.
            self._stop_directly(answer.message)

    def _stop_directly(self, reason: Message) -> None:
        """Ask the axes to stop, and report their answers."""
        answers, all_answered = self._stop_axes()
        message = Message(
            "{reason}; the axes were asked to stop directly; {answers}",
            reason=reason,
            answers=answers,
        )
        if not all_answered:
            message = message.with_fault(faults.STOP_UNCONFIRMED)
        self._emit(Answer(Request.STOP, False, message, contact=all_answered))

    def _repeat_stop(self) -> None:
        # One thread is enough, however often STOP is pressed.
        if not self._repeating_stop.acquire(blocking=False):
            return
        try:
            end_s = self._clock.now_s() + STOP_RETRIES_S
            while self._clock.now_s() < end_s:
                if self._clock.wait_s(self._stop_obsolete, STOP_RETRY_S):
                    return
                try:
                    answer = _answer_from(Request.STOP, self._stop.call(STOP_TIMEOUT_S))
                except ServiceUnavailableError as error:
                    rospy.logwarn_throttle(10.0, f"STOP is not answered: {error}")
                    continue
                self._emit(answer)
                return
        finally:
            self._repeating_stop.release()

    def _stop_axes(self) -> Tuple[Message, bool]:
        """Ask every axis to stop; return their answers, and whether all have answered."""
        answers: Dict[str, Tuple[Message, bool]] = {}
        threads = [
            threading.Thread(target=lambda axis=axis: answers.update({axis: self._stop_axis(axis)}))
            for axis in AXES
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        said = in_a_row(answers[axis][0] for axis in sorted(answers))
        return said, all(answered for _, answered in answers.values())

    def _stop_axis(self, axis: str) -> Tuple[Message, bool]:
        try:
            answer = self._axis_stops[axis].call(STOP_TIMEOUT_S)
        except ServiceUnavailableError as error:
            return Message("{axis} axis does NOT answer", axis=axis, details=error), False
        return Message("{axis} axis: {answer}", axis=axis, answer=message_from(answer)), True

    def _ask(self, request: Request, ask: Callable[[], Any]) -> None:
        in_background(lambda: self._emit(_answer(request, ask)))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for health in node_healths(message, rospy.get_namespace()):
            self._emit_received(message, health)

    def _on_replay(self, message: Replay) -> None:
        self._watch.note(message)
        self._emit_received(message, conversions.replay_mark(message))

    def _on_status(self, message: ControlStatus) -> None:
        self._watch.note(message)
        self._emit_received(message, conversions.control_state(message))


def _call_or_log(service: ServiceClient) -> None:
    try:
        service.call(PAUSE_TIMEOUT_S)
    except ServiceUnavailableError as error:
        rospy.logwarn("the replay did not answer: %s", error)


def _answer(request: Request, ask: Callable[[], Any]) -> Answer:
    try:
        return _answer_from(request, ask())
    except (ServiceUnavailableError, rospy.ROSException) as error:
        return Answer(request, False, _no_answer(error), contact=False)


def _answer_from(request: Request, response: Any) -> Answer:
    survey_id = getattr(response, "survey_id", "")
    other_analyzer = getattr(response, "other_analyzer", "")
    return Answer(request, response.success, message_from(response), survey_id, other_analyzer)


def _no_answer(error: Exception) -> Message:
    return Message(
        "the main control does not answer; check that it is running", details=error
    ).with_fault(faults.PART_SILENT)
