"""STOP: every axis and the main control are asked at the same time."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any, Callable

import rosgraph
import rospy

from gpr20_common.high.answers import message_from
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_msgs.srv import Command
from gpr20_operator.high.ros_events import CONTROL_SILENT, in_background, no_answer
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_survey.axes.axis_id import AxisId

STOP_TIMEOUT_S = 2.0
# A STOP that was not answered is repeated: the survey would continue when the link is back.
STOP_RETRY_S = 2.0
STOP_RETRIES_S = 900.0


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


class RobotStop:
    """Stops whatever moves, whoever moves it.

    Each is asked in a thread of its own, so that none waits for another that hangs.

    Args:
        emit: Takes an AxisStopAnswer of each axis and the Answer of the main control.
    """

    def __init__(self, emit: Callable[[Any], None]) -> None:
        self._emit = emit
        self._axes = {
            axis: DirectServiceClient(f"{axis.value}_axis/stop", Command) for axis in AxisId
        }
        self._control = DirectServiceClient("stop_survey", Command)
        self._repeating = threading.Lock()
        self._obsolete = threading.Event()
        self._clock = Clock()

    def remember(self) -> None:
        """Ask the master where to stop the robot; raises as `DirectServiceClient.remember`."""
        for service in (*self._axes.values(), self._control):
            service.remember()

    def press(self) -> None:
        """Ask all of them, the main control again until it answers; the answers are events."""
        self._obsolete.clear()
        # First, and not after the main control: it may be what hangs.
        for axis in AxisId:
            in_background(partial(self._stop_axis, axis))
        in_background(self._stop_survey)

    def forget(self) -> None:
        """Repeat no request: the operator has started something since, or the window closes."""
        self._obsolete.set()

    def _stop_axis(self, axis: AxisId) -> None:
        try:
            answered = bool(self._axes[axis].call(STOP_TIMEOUT_S).success)
        except ServiceUnavailableError as error:
            rospy.logwarn("the %s axis does not answer STOP: %s", axis.value, error)
            answered = False
        self._emit(AxisStopAnswer(axis, answered))

    def _stop_survey(self) -> None:
        try:
            self._emit(self._answer())
        except ServiceUnavailableError as error:
            self._emit(Answer(Request.STOP, False, no_answer(CONTROL_SILENT, error), contact=False))
            self._repeat()

    def _repeat(self) -> None:
        # One thread is enough, however often STOP is pressed.
        if not self._repeating.acquire(blocking=False):
            return
        try:
            end_s = self._clock.now_s() + STOP_RETRIES_S
            while self._clock.now_s() < end_s:
                if self._clock.wait_s(self._obsolete, STOP_RETRY_S):
                    return
                try:
                    self._emit(self._answer())
                    return
                except ServiceUnavailableError as error:
                    rospy.logwarn_throttle(10.0, f"STOP is not answered: {error}")
        finally:
            self._repeating.release()

    def _answer(self) -> Answer:
        response = self._control.call(STOP_TIMEOUT_S)
        return Answer(Request.STOP, response.success, message_from(response))
