"""One axis of the positioner, over ROS."""

from __future__ import annotations

import threading
from typing import Any, List, Optional, Tuple

import actionlib
import rospy

from gpr20_common.faults import PART_LOST
from gpr20_common.high.answers import message_from
from gpr20_common.high.raw_message import microseconds
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_main_control.errors import DeviceError, NodeLostError
from gpr20_main_control.high.ros_devices import no_answer
from gpr20_main_control.high.survey_topics import only_from
from gpr20_main_control.mid.devices.robot import AxisReading, Lease, MoveOutcome
from gpr20_msgs.msg import AxisAction, AxisGoal, AxisResult, CurrentCoordinate
from gpr20_msgs.srv import AxisLease, Command
from gpr20_survey.axes.axis_id import AxisId, ZeroEpoch
from gpr20_survey.plan.robot_description import PLAIN_NAMES

# actionlib waits longer than it is asked to, but not as long as 0, which is for ever.
SERVER_POLL_S = 0.001
STOP_LIMIT_S = 5.0
# Nothing moves, but its process of the pulses may have to be started.
SET_ZERO_LIMIT_S = 30.0
LEASE_CALL_LIMIT_S = 1.5


class RosAxis:
    """Action, topic and services of one axis; implements `Axis` of `mid.devices.robot`."""

    def __init__(self, axis_id: AxisId, clock: Clock) -> None:
        """Connect to the axis in its namespace, such as x_axis.

        `clock` measures the age of a reading; the time of day may be set meanwhile.
        """
        group = self._group = f"{axis_id.value}_axis"
        driver = f"{group}/axis_driver"
        self._plain_name = PLAIN_NAMES[driver]
        self._clock = clock
        # The last reading, and when it was received [s].
        self._last: Optional[Tuple[CurrentCoordinate, float]] = None
        self.received = threading.Event()
        # Not a SimpleActionClient: it drops what it receives about a goal before send_goal()
        # has returned, so the result of a very short move could be lost.
        self._client = _DriversClient(f"{group}/axis", driver)
        self._goal: Optional[actionlib.ClientGoalHandle] = None
        self._outcomes: List[MoveOutcome] = []
        self._homing = ServiceClient(f"{group}/homing", Command)
        self._set_zero = ServiceClient(f"{group}/set_zero", Command)
        self._stop = ServiceClient(f"{group}/stop", Command)
        # What a hung driver does late with a lease is refused or harmless.
        self._lease = ServiceClient(f"{group}/lease", AxisLease, keep_open=True)
        self._stops: List[threading.Thread] = []
        self._lock = threading.Lock()
        self._subscriber = rospy.Subscriber(
            f"{group}/current_coord",
            CurrentCoordinate,
            only_from(driver, self._note),
            queue_size=10,
        )

    def reading(self) -> Optional[AxisReading]:
        if self._last is None:
            return None
        last, received_s = self._last
        # Age by this machine's clock: the two machines' clocks may differ.
        age_s = self._clock.now_s() - received_s
        zero = ZeroEpoch(last.zero_epoch, microseconds(last.zero_time))
        return AxisReading(last.coordinate, last.homed, last.moving, age_s, zero)

    def lease(self, number: int = 0, release: bool = False) -> Lease:
        answer = self._call(self._lease, LEASE_CALL_LIMIT_S, lease=number, release=release)
        if not answer.success:
            raise DeviceError(
                Message(
                    "{device} is not free: {reason}",
                    device=self._plain_name,
                    reason=message_from(answer),
                )
            )
        return Lease(answer.lease, answer.limit_s)

    def is_connected(self) -> bool:
        return bool(self._client.wait_for_server(rospy.Duration(SERVER_POLL_S)))

    def begin_move(self, target: float) -> None:
        self._await_stops()
        outcomes: List[MoveOutcome] = []

        def note(goal: actionlib.ClientGoalHandle) -> None:
            if goal.get_comm_state() == actionlib.CommState.DONE:
                outcomes.append(_outcome(goal))
                self.received.set()

        self._outcomes = outcomes
        # Stored, because a goal whose handle is deleted is no longer followed.
        self._goal = self._client.send_goal(AxisGoal(target_coordinate=target), note)

    def move_outcome(self) -> Optional[MoveOutcome]:
        return self._outcomes[0] if self._outcomes else None

    def home(self, time_limit_s: float) -> None:
        self._await_stops()
        self._succeed(self._homing, time_limit_s)

    def set_zero(self) -> None:
        self._succeed(self._set_zero, SET_ZERO_LIMIT_S)

    def _succeed(self, service: ServiceClient, time_limit_s: float) -> None:
        answer = self._call(service, time_limit_s)
        if not answer.success:
            outcome = MoveOutcome(False, message_from(answer))
            raise (NodeLostError if outcome.contact_lost else DeviceError)(outcome.message)

    def _call(self, service: ServiceClient, time_limit_s: float, **fields: Any) -> Any:
        try:
            return service.call(time_limit_s, **fields)
        except ServiceUnavailableError as error:
            # A homing may have begun, and continue.
            fault = PART_LOST if service is self._homing else None
            raise NodeLostError(no_answer(self._plain_name, error), fault=fault) from error

    def stop(self) -> None:
        # A homing that waits for a lost node must not begin when the node is back.
        self._homing.give_up()
        goal = self._goal
        if goal is not None and goal.get_comm_state() != actionlib.CommState.DONE:
            # On an open connection: it arrives before the call, which has to connect first.
            goal.cancel()
        thread = threading.Thread(target=self._stop_now, name=f"stop {self._group}", daemon=True)
        with self._lock:
            thread.start()
            self._stops = [*filter(threading.Thread.is_alive, self._stops), thread]

    def _await_stops(self) -> None:
        """Return when no stop is pending: a late one would end the motion that begins now."""
        with self._lock:
            stops = self._stops
        for one in stops:
            one.join(2.0 * STOP_LIMIT_S)

    def _stop_now(self) -> None:
        try:
            self._stop.call(STOP_LIMIT_S)
        except ServiceUnavailableError as error:
            # The motion of a driver that died, or is unreachable, ends by itself; if it is only
            # slow, this must be visible. When the robot is shut down, its axes stop by
            # themselves, and their nodes may have ended already.
            log = rospy.loginfo if rospy.core.is_shutdown_requested() else rospy.logerr
            log("%s could not be stopped: %s", self._group, error)

    def _note(self, message: CurrentCoordinate) -> None:
        self._last = message, self._clock.now_s()
        self.received.set()


class _DriversClient(actionlib.ActionClient):
    """An action client that listens to the driver of the axis alone."""

    def __init__(self, name: str, driver: str) -> None:
        # The base class subscribes with these.
        for callback in ("_status_cb", "_result_cb"):
            setattr(self, callback, only_from(driver, getattr(self, callback)))
        super().__init__(name, AxisAction)


def _outcome(goal: actionlib.ClientGoalHandle) -> MoveOutcome:
    result: Optional[AxisResult] = goal.get_result()
    text = goal.get_goal_status_text()
    if result is None:
        no_result = Message("the move ended without a result", details=text).with_fault(PART_LOST)
        return MoveOutcome(False, no_result)
    # The result of a goal that actionlib itself refused has no message.
    message = message_from(result) if result.message else verbatim(text)
    return MoveOutcome(result.success, message)
