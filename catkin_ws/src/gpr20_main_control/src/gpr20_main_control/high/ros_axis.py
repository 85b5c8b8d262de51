"""One axis of the positioner, over ROS."""

from __future__ import annotations

import queue
import threading
from typing import List, Optional, Set

import actionlib
import rospy
from std_srvs.srv import Trigger

from gpr20_common.high.connection_header import connection_header
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.robot import AxisReading, MoveOutcome
from gpr20_msgs.msg import AxisAction, AxisGoal, AxisResult, CurrentCoordinate

SERVER_LIMIT_S = 2.0
STOP_LIMIT_S = 1.0
# The node of an axis, in the axis's namespace.
DRIVER = "axis_driver"


class RosAxis:
    """Action, topic and services of one axis; implements `gpr20_main_control.mid.robot.Axis`."""

    def __init__(self, group: str, clock: Clock) -> None:
        """Connect to the axis whose names begin with `group`, such as x_axis.

        Args:
            group: Namespace of the axis.
            clock: Tells how old a reading is; the time of day may be set meanwhile.
        """
        self._group = group
        self._clock = clock
        self._driver = rospy.resolve_name(f"{group}/{DRIVER}")
        self._strangers: Set[str] = set()
        self._lock = threading.Lock()
        self._last: Optional[CurrentCoordinate] = None
        self._heard_s = 0.0
        self._outcomes: queue.Queue = queue.Queue()
        # Not a SimpleActionClient: that one drops whatever it hears of a goal before
        # send_goal() has returned, so the result of a very short move could be lost.
        self._client = actionlib.ActionClient(f"{group}/axis", AxisAction)
        self._goal: Optional[actionlib.ClientGoalHandle] = None
        self._homing = ServiceClient(f"{group}/homing", Trigger)
        self._stop = ServiceClient(f"{group}/stop", Trigger)
        self._stops: List[threading.Thread] = []
        self._subscriber = rospy.Subscriber(
            f"{group}/current_coord", CurrentCoordinate, self._hear, queue_size=10
        )

    def reading(self) -> Optional[AxisReading]:
        """Return what the axis last said of itself; None if it never did."""
        with self._lock:
            last, heard_s = self._last, self._heard_s
        if last is None:
            return None
        # Age by this machine's clock: the two machines' clocks may differ.
        age_s = self._clock.now_s() - heard_s
        return AxisReading(last.coordinate, last.homed, last.moving, age_s)

    def begin_move(self, target: float) -> None:
        """Send the axis to a target [mm or deg] and return at once.

        Raises:
            DeviceError: The axis's node is not there.
        """
        self._await_stops()
        if not self._client.wait_for_server(rospy.Duration(SERVER_LIMIT_S)):
            raise DeviceError(
                f"{self._group} does not answer; check that its axis_driver node runs"
            )
        outcomes: queue.Queue = queue.Queue()

        def note(goal: actionlib.ClientGoalHandle) -> None:
            if goal.get_comm_state() == actionlib.CommState.DONE:
                outcomes.put(_outcome(goal))

        self._outcomes = outcomes
        # Kept, because a goal whose handle is gone is no longer followed.
        self._goal = self._client.send_goal(AxisGoal(target_coordinate=target), note)

    def move_outcome(self, wait_s: float) -> Optional[MoveOutcome]:
        """Wait up to `wait_s` [s] for the end of the move; None while it goes on."""
        try:
            return self._outcomes.get(timeout=wait_s)
        except queue.Empty:
            return None

    def home(self, time_limit_s: float) -> None:
        """Home the axis and return when it is homed.

        Raises:
            DeviceError: It failed, or did not end in time.
        """
        self._await_stops()
        try:
            response = self._homing.call(time_limit_s)
        except ServiceUnavailableError as error:
            raise DeviceError(str(error)) from error
        if not response.success:
            raise DeviceError(response.message)

    def stop(self) -> None:
        """End any motion; returns at once."""
        # A homing that waits for a node which is away must not begin when it is back.
        self._homing.give_up()
        thread = threading.Thread(target=self._stop_now, daemon=True)
        with self._lock:
            thread.start()
            self._stops = [*filter(threading.Thread.is_alive, self._stops), thread]

    def _await_stops(self) -> None:
        """Return when no stop is on its way: a late one would end what begins now."""
        with self._lock:
            stops = self._stops
        for one in stops:
            one.join(2.0 * STOP_LIMIT_S)

    def _stop_now(self) -> None:
        try:
            self._stop.call(STOP_LIMIT_S)
        except ServiceUnavailableError as error:
            # A node that is gone moves nothing; if it lives, this must be seen.
            rospy.logerr("%s could not be stopped: %s", self._group, error)

    def _hear(self, message: CurrentCoordinate) -> None:
        # A recording that is played beside the robot says where another robot stood: a trace
        # could be taken for one from there.
        speaker = connection_header(message)["callerid"]
        if speaker != self._driver:
            self._ignore(speaker)
            return
        with self._lock:
            self._last = message
            self._heard_s = self._clock.now_s()

    def _ignore(self, speaker: str) -> None:
        if speaker in self._strangers:
            return
        self._strangers.add(speaker)
        rospy.logerr(
            "%s publishes coordinates of %s beside %s; they are ignored: end it, a recording "
            "must be played on a master of its own",
            speaker,
            self._group,
            self._driver,
        )


def _outcome(goal: actionlib.ClientGoalHandle) -> MoveOutcome:
    result: Optional[AxisResult] = goal.get_result()
    text = goal.get_goal_status_text()
    if result is None:
        return MoveOutcome(False, text or "it ended without a result")
    # The result of a goal that actionlib itself refused says nothing.
    return MoveOutcome(result.success, result.message or text)
