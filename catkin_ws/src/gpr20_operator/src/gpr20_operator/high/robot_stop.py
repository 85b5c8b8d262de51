"""STOP: every axis and the main control are asked at the same time."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any, Callable, Optional

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

    _address = ""

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


class _Stop:
    """One that is asked to stop, and again until it answers or that is `obsolete`.

    Of the first attempt and of a later answer `event` makes what is emitted: of the response, or
    of None and why there is none.
    """

    def __init__(
        self,
        name: str,
        emit: Callable[[Any], None],
        event: Callable[[Any, Optional[Exception]], Any],
        obsolete: threading.Event,
    ) -> None:
        self.service = DirectServiceClient(name, Command)
        self._emit, self._event, self._obsolete = emit, event, obsolete
        self._repeating, self._clock = threading.Lock(), Clock()

    def ask(self) -> None:
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
            response = self.service.call(STOP_TIMEOUT_S)
        except ServiceUnavailableError as error:
            rospy.logwarn_throttle(10.0, f"STOP is not answered: {error}")
            if not again:
                self._emit(self._event(None, error))
            return False
        self._emit(self._event(response, None))
        return True


class RobotStop:
    """Stops whatever moves, whoever moves it.

    Each is asked in a thread of its own, so that none waits for another that hangs.

    Args:
        emit: Takes an AxisStopAnswer of each axis and the Answer of the main control.
    """

    def __init__(self, emit: Callable[[Any], None]) -> None:
        self._obsolete = threading.Event()
        axes = [(f"{axis.value}_axis/stop", partial(_axis_answer, axis)) for axis in AxisId]
        # The axes first: the main control may be what hangs.
        self._stops = [_Stop(name, emit, event, self._obsolete) for name, event in axes]
        self._stops.append(_Stop("stop_survey", emit, _control_answer, self._obsolete))

    def remember(self) -> None:
        """Ask the master where to stop the robot; raises as `DirectServiceClient.remember`."""
        for one in self._stops:
            one.service.remember()

    def press(self) -> None:
        """Ask all of them, each again until it answers; the answers are events."""
        self._obsolete.clear()
        for one in self._stops:
            in_background(one.ask)

    def forget(self) -> None:
        """Repeat no request: the operator has started something since, or the window closes."""
        self._obsolete.set()


def _axis_answer(axis: AxisId, response: Any, _error: Optional[Exception]) -> AxisStopAnswer:
    return AxisStopAnswer(axis, response is not None and bool(response.success))


def _control_answer(response: Any, error: Optional[Exception]) -> Answer:
    if error is not None:
        return Answer(Request.STOP, False, no_answer(CONTROL_SILENT, error), contact=False)
    return Answer(Request.STOP, response.success, message_from(response))
