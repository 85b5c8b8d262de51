"""STOP: every axis and the main control are asked at the same time."""

from __future__ import annotations

import threading
from typing import Any, Callable, List, Optional

import rosgraph
import rospy

from gpr20_common.high.answers import message_from
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_msgs.srv import Command
from gpr20_operator.high.ros_events import CONTROL_SILENT, in_background, no_answer
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_survey.axes import AxisId

STOP_TIMEOUT_S = 2.0
# A STOP that was not answered is repeated: the survey would continue when the link is back.
STOP_RETRY_S = 2.0
STOP_RETRIES_S = 900.0


class StopService(ServiceClient):
    """One that is asked to stop, and again until it answers or `obsolete` is set.

    It remembers the address of the service: STOP must work while the master is away.

    Args:
        axis: Whose service it is; None: that of the main control.
        emit: Takes what came of the first attempt, and a later answer.
        obsolete: Set: no attempt is repeated.
    """

    def __init__(
        self, axis: Optional[AxisId], emit: Callable[[Any], None], obsolete: threading.Event
    ) -> None:
        super().__init__("stop_survey" if axis is None else f"{axis.value}_axis/stop", Command)
        self._axis, self._emit, self._obsolete = axis, emit, obsolete
        self._address = ""
        self._repeating, self._clock = threading.Lock(), Clock()

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

    def ask(self) -> None:
        """Ask it to stop, and again until it answers."""
        if self._attempt() or not self._repeating.acquire(blocking=False):
            return  # one thread that repeats it is enough, however often STOP is pressed
        try:
            end_s = self._clock.now_s() + STOP_RETRIES_S
            while self._clock.now_s() < end_s:
                if self._clock.wait_s(self._obsolete, STOP_RETRY_S) or self._attempt(again=True):
                    return
        finally:
            self._repeating.release()

    def _attempt(self, again: bool = False) -> bool:
        try:
            response = self.call(STOP_TIMEOUT_S)
        except ServiceUnavailableError as error:
            rospy.logwarn_throttle(10.0, f"STOP is not answered: {error}")
            if not again:
                silent = no_answer(CONTROL_SILENT, error)
                self._say(False, Answer(Request.STOP, False, silent, contact=False))
            return False
        answer = Answer(Request.STOP, response.success, message_from(response))
        self._say(response.success, answer)
        return True

    def _say(self, answered: bool, answer: Answer) -> None:
        self._emit(answer if self._axis is None else AxisStopAnswer(self._axis, answered))

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
        self._obsolete = threading.Event()
        # The axes first: the main control may be what hangs.
        asked: List[Optional[AxisId]] = [*AxisId, None]
        self._services = [StopService(axis, emit, self._obsolete) for axis in asked]

    def remember(self) -> None:
        """Ask the master where to stop the robot; raises as `StopService.remember`."""
        for one in self._services:
            one.remember()

    def press(self) -> None:
        """Ask all of them, each again until it answers; the answers are events."""
        self._obsolete.clear()
        for one in self._services:
            in_background(one.ask)

    def forget(self) -> None:
        """Repeat no request: the operator has started something since, or the window closes."""
        self._obsolete.set()
