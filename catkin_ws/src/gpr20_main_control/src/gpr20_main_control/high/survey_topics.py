"""The topics of the survey and of what the robot is."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from functools import partial
from typing import Any, Callable, Optional, Sequence, Tuple

import rospy

from gpr20_common.high.answers import fault_of, message_fields
from gpr20_common.high.node import DESCRIPTION
from gpr20_common.high.raw_message import connection_header, ros_time
from gpr20_common.message import Message
from gpr20_main_control.mid.devices.described_robot import NEEDED_NODES, DescribedRobot
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.survey.survey_status import Coverage, Status
from gpr20_msgs import msg
from gpr20_survey.axes import BASE_LINK
from gpr20_survey.plan.robot_description import SIMULATOR, NodeDescription
from gpr20_survey.plan.survey_parameters import SurveyParameters

NO_TARGET = -1.0
# The progress, and a position that stays the same, are published at each fifth tick: 2 Hz.
SLOW_TICKS = 5


class SurveyTopics:
    """The publishers of the survey.

    Attributes:
        simulated: Whether the robot is known to be simulated; a field of every status.
    """

    def __init__(self) -> None:
        """Advertise the topics."""
        self.simulated = False
        self._position: Tuple[float, ...] = ()
        self._ticks = 0
        topic = partial(rospy.Publisher, queue_size=10)
        latched = partial(topic, latch=True)
        self._status = latched("control_status", msg.ControlStatus)
        self._target = topic("control_target_coordinate", msg.Coordinates)
        self._current = topic("control_current_coordinate", msg.Coordinates)
        self._progress = topic("control_survey_data", msg.SurveyData)
        self._coverage = latched("survey_coverage", msg.SurveyCoverage)
        self._service = latched("service_status", msg.ServiceStatus)
        self._robot = latched("robot_configuration", msg.RobotConfiguration)
        self._parameters = latched("survey_parameters", msg.SurveyParameters)

    def publish_change(self, before: Status, after: Status) -> None:
        """Publish a change of the status."""

        def changed(*names: str) -> bool:
            return any(getattr(before, name) != getattr(after, name) for name in names)

        if changed("state", "full_message", "plan_id", "plan_set_by"):
            rospy.loginfo("%s: %s", after.state.name, after.full_message)
            self.publish_status(after)
        if changed("target"):
            self._publish_target(after)
        if changed("survey_id", "total_points", "visited_points", "remaining_s"):
            self._progress.publish(progress_message(after))

    def publish_status(self, status: Status) -> None:
        self._status.publish(self.status_message(status))

    def status_message(self, status: Status) -> msg.ControlStatus:
        """Return the message with state and message."""
        return _stamped(
            msg.ControlStatus,
            code=int(status.state),
            survey_id=status.survey_id,
            simulated=self.simulated,
            plan_id=status.plan_id,
            plan_set_by=status.plan_set_by,
            end=int(status.end),
            ended=ros_time(status.ended_us),
            **message_fields(status.full_message),
        )

    def _publish_target(self, status: Status) -> None:
        target = status.target
        place = (NO_TARGET,) * 3
        if target is not None:
            place = target.x_mm, target.y_mm, target.z_deg
        self._target.publish(_coordinates(place))

    def publish_coverage(self, coverage: Coverage, survey_id: str) -> None:
        self._coverage.publish(coverage_message(coverage, survey_id))

    def publish_parameters(self, parameters: SurveyParameters) -> None:
        self._parameters.publish(msg.SurveyParameters(**asdict(parameters)))

    def publish_service(self, activity: Optional[Message]) -> None:
        """Publish what is done for maintenance; None: nothing."""
        fields = message_fields(activity) if activity is not None else {}
        if activity is not None:
            rospy.loginfo("service: %s", activity)
        self._service.publish(msg.ServiceStatus(busy=activity is not None, **fields))

    def publish_robot(self, robot: DescribedRobot) -> None:
        """Publish what the nodes of the robot say together."""
        problem = robot.problem
        message = _stamped(
            msg.RobotConfiguration,
            known=problem is None,
            simulated=problem is None and robot.config().simulated,
            nodes=[
                msg.NodeDescription(**one.fields()) for _name, one in sorted(robot.nodes.items())
            ],
            site_json=json.dumps(asdict(robot.site)),
            **({} if problem is None else message_fields(problem)),
        )
        self._robot.publish(message)

    def publish(self, robot: Robot, status: Status) -> None:
        """Publish the position of the axes, once all have reported theirs, and the progress.

        Called 10 times a second.
        """
        self._ticks += 1
        if self._ticks % SLOW_TICKS == 0:
            self._publish_target(status)
            self._progress.publish(progress_message(status))
        readings = [axis.reading() for axis in robot.axes.values()]
        present = tuple(reading.coordinate for reading in readings if reading is not None)
        changed = present != self._position
        if len(present) == len(readings) and (changed or self._ticks % SLOW_TICKS == 0):
            self._position = present
            self._current.publish(_coordinates(present))


def only_from(node: str, receive: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return what calls `receive` with messages of one node alone, and names others once.

    A recording that is played beside the robot publishes what the nodes of another robot said: a
    trace could be stored with one of its positions, and a goal that it does not list counts as
    lost.
    """
    full_name, ignored = rospy.resolve_name(node), set()

    def receive_own(message: Any) -> None:
        publisher = connection_header(message)["callerid"]
        if publisher == full_name:
            receive(message)
        elif publisher not in ignored:
            ignored.add(publisher)
            rospy.logerr(
                "%s publishes messages of %s; they are ignored: end it, and play recordings "
                "under other names (rosbag play --prefix=/replay)",
                publisher,
                full_name,
            )

    return receive_own


def listen_to_nodes(note: Callable[[NodeDescription], None]) -> None:
    """Call `note` with the description of each node, now and whenever it starts again."""

    def receive(node: str, message: Any) -> None:
        note(replace(NodeDescription.from_fields(message), node=node))

    for node in (*NEEDED_NODES, SIMULATOR):
        own = only_from(node, partial(receive, node))
        rospy.Subscriber(f"{node}/{DESCRIPTION}", msg.NodeDescription, own)


def _coordinates(place: Sequence[float]) -> msg.Coordinates:
    x_mm, y_mm, z_deg = place
    message = _stamped(msg.Coordinates, x_mm=x_mm, y_mm=y_mm, z_deg=z_deg)
    message.header.frame_id = BASE_LINK
    return message


def progress_message(status: Status) -> msg.SurveyData:
    """Return the message with the progress of the survey."""
    return _stamped(
        msg.SurveyData,
        survey_id=status.survey_id,
        completion_percent=100.0 * status.visited_points / max(1, status.total_points),
        total_points=status.total_points,
        visited_points=status.visited_points,
        remaining_points=status.total_points - status.visited_points,
        remaining_time=rospy.Duration.from_sec(status.remaining_s),
    )


def coverage_message(coverage: Coverage, survey_id: str) -> msg.SurveyCoverage:
    """Return the message with the state of each planned sample."""
    reasons = sorted(coverage.reasons.items())
    verdict, runs = coverage.verdict().message, coverage.runs()
    return _stamped(
        msg.SurveyCoverage,
        survey_id=survey_id,
        planned=coverage.planned,
        run_starts=[start for start, _state in runs],
        run_states=bytes(state for _start, state in runs),
        failures=[f"{index}: {reason}" for index, reason in reasons],
        failure_faults=[fault_of(reason) for _index, reason in reasons],
        verdict=str(verdict),
        verdict_fault=fault_of(verdict),
    )


def _stamped(kind: Any, **fields: Any) -> Any:
    message = kind(**fields)
    message.header.stamp = rospy.Time.now()
    return message
