"""The main control's topics and services as events of this package."""

from __future__ import annotations

import queue
import threading
from typing import Any, Callable, Dict

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Range

from gpr20_common.high.graph_message import message_from
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message, in_a_row
from gpr20_msgs.msg import ControlStatus, Coordinates, RobotConfiguration, SurveyData
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
from gpr20_msgs.srv import Command, ResumeSurvey, SetSurveyParameters, StartSurvey
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.high import conversions
from gpr20_user_interface.high.master import MasterWatch
from gpr20_user_interface.high.robot_travel import axis_limits
from gpr20_user_interface.high.ros_events import RosEvents, in_background
from gpr20_user_interface.mid.events import Accepted, Answer, AxisLimits, Event, Request

SET_TIMEOUT_S = 10.0
PAUSE_TIMEOUT_S = 10.0
# STOP must not wait for a main control that hangs: then it goes to the axes directly.
STOP_TIMEOUT_S = 2.0
AXES = ("x", "y", "z")
# Checks of the devices come before the answer, and homing may: at the lowest speed an axis
# of 800 mm takes 800 s. The survey can be stopped meanwhile.
START_TIMEOUT_S = 1200.0


class DirectServiceClient(ServiceClient):
    """Remembers the address of a service: STOP must work while the master is away."""

    def __init__(self, name: str, service_class: Any) -> None:
        super().__init__(name, service_class)
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

    def _ask(
        self, timeout_s: float, arguments: Any, answers: queue.Queue, given_up: threading.Event
    ) -> None:
        if self._address:
            proxy = _AddressedProxy(self.name, self._service_class, self._address)
            request, fields = arguments
            try:
                answers.put(proxy(*request, **fields))
                return
            except (rospy.ROSException, rospy.ServiceException, OSError):
                # It has ended or has another address: the master may know.
                pass
        super()._ask(timeout_s, arguments, answers, given_up)


class _AddressedProxy(rospy.ServiceProxy):
    def __init__(self, name: str, service_class: Any, address: str) -> None:
        super().__init__(name, service_class)
        self._address = address

    def _get_service_uri(self, _request: Any) -> str:
        return self._address


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
        self._master = MasterWatch()
        self._checking_master = threading.Lock()
        self._limits = AxisLimits(None)

    def listen(self) -> None:
        """Subscribe to state and progress of the survey."""
        self._subscribe("control_status", ControlStatus, conversions.control_state, None)
        self._subscribe("control_survey_data", SurveyData, conversions.progress, None)
        self._subscribe("robot_configuration", RobotConfiguration, self._note_robot, None)

    def listen_to_robot(self) -> None:
        """Subscribe to position, height and health of the robot."""
        subscribe = self._subscribe
        subscribe("control_current_coordinate", Coordinates, conversions.current_position, 1)
        subscribe("control_target_coordinate", Coordinates, conversions.target_position, 1)
        subscribe("survey_parameters", SurveyParametersMessage, conversions.parameters, None)
        subscribe("measured_height", Range, conversions.measured_height, 1)
        self._subscribe_raw("/diagnostics", DiagnosticArray, self._on_diagnostics, 20)

    def start_survey(self, parameters: SurveyParameters) -> None:
        """Ask to accept the parameters and to start; the answer is an event."""
        self._ask(Request.START, lambda: self._ask_start(parameters))

    def stop_survey(self) -> None:
        """Ask to stop the survey; the answer is an event."""
        in_background(lambda: self._emit(self._stop_answer()))

    def pause_survey(self) -> None:
        """Ask to pause the survey; the answer is an event."""
        self._ask(Request.PAUSE, lambda: self._pause.call(PAUSE_TIMEOUT_S))

    def resume_survey(self, survey_id: str = "") -> None:
        """Ask to resume the paused survey or the one named; the answer is an event."""
        self._ask(Request.RESUME, lambda: self._ask_resume(survey_id))

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
            self._emit(AxisLimits(None, reason, master_alive=False))
        finally:
            self._checking_master.release()

    def _note_robot(self, message: RobotConfiguration) -> AxisLimits:
        self._limits = axis_limits(message)
        return self._limits

    def _ask_start(self, parameters: SurveyParameters) -> Any:
        message = conversions.parameters_message(parameters)
        accepted = self._set_parameters.call(SET_TIMEOUT_S, parameters=message)
        if not accepted.success:
            return accepted
        self._emit(Accepted(accepted.total_points, accepted.estimated_time.to_sec()))
        return self._start.call(START_TIMEOUT_S)

    def _stop_answer(self) -> Answer:
        try:
            return _answer_from(Request.STOP, self._stop.call(STOP_TIMEOUT_S))
        except ServiceUnavailableError as error:
            message = Message(
                "{reason}; the axes were asked to stop directly; {answers}",
                reason=_no_answer(error),
                answers=self._stop_axes(),
            )
            return Answer(Request.STOP, False, message)

    def _stop_axes(self) -> Message:
        answers: Dict[str, Message] = {}
        threads = [
            threading.Thread(target=lambda axis=axis: answers.update({axis: self._stop_axis(axis)}))
            for axis in AXES
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return in_a_row(answers[axis] for axis in sorted(answers))

    def _stop_axis(self, axis: str) -> Message:
        try:
            answer = self._axis_stops[axis].call(STOP_TIMEOUT_S)
        except ServiceUnavailableError as error:
            return Message("{axis} axis does NOT answer", axis=axis, details=error)
        return Message("{axis} axis: {answer}", axis=axis, answer=message_from(answer))

    def _ask_resume(self, survey_id: str) -> Any:
        # The long limit is for the answer, not for a service that is not there.
        rospy.wait_for_service(self._resume.name, timeout=SET_TIMEOUT_S)
        return self._resume.call(START_TIMEOUT_S, survey=survey_id)

    def _ask(self, request: Request, ask: Callable[[], Any]) -> None:
        in_background(lambda: self._emit(_answer(request, ask)))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for health in conversions.node_healths(message, rospy.get_namespace()):
            self._emit(health)


def _answer(request: Request, ask: Callable[[], Any]) -> Answer:
    try:
        return _answer_from(request, ask())
    except (ServiceUnavailableError, rospy.ROSException) as error:
        return Answer(request, False, _no_answer(error))


def _answer_from(request: Request, response: Any) -> Answer:
    survey_id = getattr(response, "survey_id", "")
    return Answer(request, response.success, message_from(response), survey_id)


def _no_answer(error: Exception) -> Message:
    return Message("the main control does not answer; check that it is running", details=error)
