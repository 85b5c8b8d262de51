"""The topics of the survey."""

from __future__ import annotations

from dataclasses import asdict
from typing import Optional, Tuple

import rospy

from gpr20_common.high.answers import fault_of, message_fields
from gpr20_common.high.raw_message import ros_time
from gpr20_common.message import Message
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.survey.survey_coverage import Coverage
from gpr20_main_control.mid.survey.survey_status import Status
from gpr20_msgs.msg import (
    ControlStatus,
    Coordinates,
    ServiceStatus,
    SurveyCoverage,
    SurveyData,
)
from gpr20_msgs.msg import SurveyParameters as SurveyParametersMessage
from gpr20_survey.axes.axis_id import BASE_LINK
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import SurveyState

NO_TARGET = -1.0
# A position that stays the same is published at each fifth tick: 2 Hz.
UNCHANGED_TICKS = 5


class SurveyTopics:
    """The publishers of the survey.

    Attributes:
        simulated: Whether the robot is known to be simulated; a field of every status.
    """

    def __init__(self) -> None:
        """Advertise the topics."""
        self.simulated = False
        self._position: Tuple[float, ...] = ()
        self._unchanged = 0
        self._status = rospy.Publisher("control_status", ControlStatus, queue_size=10, latch=True)
        self._target = rospy.Publisher("control_target_coordinate", Coordinates, queue_size=10)
        self._current = rospy.Publisher("control_current_coordinate", Coordinates, queue_size=10)
        self._progress = rospy.Publisher("control_survey_data", SurveyData, queue_size=10)
        self._coverage = rospy.Publisher(
            "survey_coverage", SurveyCoverage, queue_size=10, latch=True
        )
        self._service = rospy.Publisher("service_status", ServiceStatus, queue_size=10, latch=True)
        self._parameters = rospy.Publisher(
            "survey_parameters", SurveyParametersMessage, queue_size=10, latch=True
        )

    def publish_change(self, before: Status, after: Status) -> None:
        """Publish a change of the status."""
        if stated(before) != stated(after):
            rospy.loginfo("%s: %s", after.state.name, after.full_message)
            self.publish_status(after)
        if before.target != after.target:
            self._publish_target(after)
        if progress_of(before) != progress_of(after):
            self._progress.publish(progress_message(after))

    def publish_status(self, status: Status) -> None:
        self._status.publish(self.status_message(status))

    def status_message(self, status: Status) -> ControlStatus:
        """Return the message with state and message."""
        message = ControlStatus(**message_fields(status.full_message))
        message.header.stamp = rospy.Time.now()
        message.code = int(status.state)
        message.survey_id = status.survey_id
        message.simulated = self.simulated
        message.plan_id = status.plan_id
        message.plan_set_by = status.plan_set_by
        message.end, message.ended = int(status.end), ros_time(status.ended_us)
        return message

    def _publish_target(self, status: Status) -> None:
        message = Coordinates()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = BASE_LINK
        target = status.target
        message.x_mm = NO_TARGET if target is None else target.x_mm
        message.y_mm = NO_TARGET if target is None else target.y_mm
        message.z_deg = NO_TARGET if target is None else target.z_deg
        self._target.publish(message)

    def publish_progress(self, status: Status) -> None:
        self._publish_target(status)
        self._progress.publish(progress_message(status))

    def publish_coverage(self, coverage: Coverage, survey_id: str) -> None:
        self._coverage.publish(coverage_message(coverage, survey_id))

    def publish_parameters(self, parameters: SurveyParameters) -> None:
        self._parameters.publish(SurveyParametersMessage(**asdict(parameters)))

    def publish_service(self, activity: Optional[Message]) -> None:
        """Publish what is done for maintenance; None: nothing."""
        fields = message_fields(activity) if activity is not None else {}
        if activity is not None:
            rospy.loginfo("service: %s", activity)
        self._service.publish(ServiceStatus(busy=activity is not None, **fields))

    def publish_current(self, robot: Robot) -> None:
        """Publish the position of the axes, once all of them have reported theirs.

        Called 10 times a second; a position that has not changed is published twice a second.
        """
        readings = [axis.reading() for axis in robot.axes.values()]
        present = tuple(reading.coordinate for reading in readings if reading is not None)
        if len(present) < len(readings):
            return
        self._unchanged = self._unchanged + 1 if present == self._position else 0
        self._position = present
        if self._unchanged % UNCHANGED_TICKS:
            return
        message = Coordinates()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = BASE_LINK
        message.x_mm, message.y_mm, message.z_deg = present
        self._current.publish(message)


def stated(status: Status) -> Tuple[SurveyState, Message, str, str]:
    """Return the content of the message with state and message."""
    return status.state, status.full_message, status.plan_id, status.plan_set_by


def progress_of(status: Status) -> Tuple[str, int, int, float]:
    """Return the content of the message with the progress of the survey."""
    return status.survey_id, status.total_points, status.visited_points, status.remaining_s


def progress_message(status: Status) -> SurveyData:
    """Return the message with the progress of the survey."""
    message = SurveyData()
    message.header.stamp = rospy.Time.now()
    message.survey_id = status.survey_id
    message.completion_percent = status.completion_percent
    message.total_points = status.total_points
    message.visited_points = status.visited_points
    message.remaining_points = status.total_points - status.visited_points
    message.remaining_time = rospy.Duration.from_sec(status.remaining_s)
    return message


def coverage_message(coverage: Coverage, survey_id: str) -> SurveyCoverage:
    """Return the message with the state of each planned sample."""
    reasons = sorted(coverage.reasons.items())
    verdict = coverage.verdict().message
    message = SurveyCoverage()
    message.header.stamp = rospy.Time.now()
    message.survey_id = survey_id
    runs = coverage.runs()
    message.planned = coverage.planned
    message.run_starts = [start for start, _state in runs]
    message.run_states = bytes(state for _start, state in runs)
    message.failures = [f"{index}: {reason}" for index, reason in reasons]
    message.failure_faults = [fault_of(reason) for _index, reason in reasons]
    message.verdict = str(verdict)
    message.verdict_fault = fault_of(verdict)
    return message
