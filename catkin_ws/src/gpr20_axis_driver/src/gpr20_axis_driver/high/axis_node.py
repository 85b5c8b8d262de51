"""The ROS interface of one axis."""

from __future__ import annotations

import math
import time
from contextlib import contextmanager
from typing import Callable, Iterator, Optional, Tuple

import rospy
from std_msgs.msg import Bool

from gpr20_axis_driver.axis_exceptions import AxisException, MotionStopped
from gpr20_axis_driver.high.goals import ClientContact, GoalServer
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.axis_lease import AxisLease
from gpr20_axis_driver.motion import AxisMotions
from gpr20_common.faults import OVERLOADED
from gpr20_common.high import diagnostics
from gpr20_common.high.answers import advertise, internal_error, message_fields
from gpr20_common.high.description import publish_description
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.raw_message import connection_header, ros_time
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_msgs.msg import AxisAction, AxisGoal, AxisResult, CurrentCoordinate
from gpr20_msgs.srv import AxisLease as AxisLeaseService
from gpr20_msgs.srv import AxisLeaseRequest as AxisLeaseServiceRequest
from gpr20_msgs.srv import AxisLeaseResponse as AxisLeaseServiceResponse
from gpr20_msgs.srv import Command, CommandRequest, CommandResponse
from gpr20_survey.axes.axis_id import BASE_LINK, AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.faults import CONTROL_SILENT, NOT_HOMED

NO_CONTACT = Message("the axis stopped because it had no contact with the main control").with_fault(
    CONTROL_SILENT
)
MOVING_PERIOD_S = 1.0 / 50
RESTING_PERIOD_S = 1.0 / 10
# At rest every fifth tick is published, until the ticks become slower.
RESTING_TICKS = round(RESTING_PERIOD_S / MOVING_PERIOD_S)
# Moves that follow each other within this time [s] do not change the ticks.
SOON_S = 1.0
SHUTDOWN_LIMIT_S = 5.0


class AxisNode:
    """Action `axis`, topic `current_coord`, services `homing`, `stop` and `lease` of one axis.

    An axis with an endstop publishes its state on the topic `endstop`; one without endstop has the
    service `set_zero`.
    """

    def __init__(
        self,
        axis_id: AxisId,
        parameters: AxisParameters,
        driver: AxisDriver,
        motions: AxisMotions,
        hardware: Hardware,
    ) -> None:
        self._driver = driver
        self._motions = motions
        self._unit = parameters.unit
        self._stops = 0
        self._last_error: Optional[Message] = None
        self._ticks = 0
        self._fast = False
        self._moved_s = -math.inf
        self._publisher = rospy.Publisher("current_coord", CurrentCoordinate, queue_size=10)
        self._presses = driver.endstop_presses
        self._endstop_publisher: Optional[rospy.Publisher] = None
        if parameters.finds_zero:
            self._endstop_publisher = rospy.Publisher("endstop", Bool, queue_size=1)
        self._lease = AxisLease(parameters.lease_limit_s)
        self._server = GoalServer("axis", AxisAction, self._execute, self._lease.check)
        self._diagnostics = diagnostics.Diagnostics(hardware.name, self._health)
        self._periodic = Periodic(RESTING_PERIOD_S, self._tick)
        rospy.on_shutdown(self._shut_down)
        self._server.start()
        self._services = [
            advertise("homing", Command, self._home),
            advertise("stop", Command, self._stop),
            advertise("lease", AxisLeaseService, self._reserve),
        ]
        if not parameters.finds_zero:
            self._services.append(advertise("set_zero", Command, self._set_zero))
        self._description = publish_description(
            f"{axis_id.value}_axis/{rospy.get_name().rsplit('/', 1)[-1]}",
            hardware,
            parameters,
        )

    def _execute(self, goal: AxisGoal) -> None:
        stops = self._stop_since_now()
        contact = ClientContact(self._server.watch_sender())

        def stopped() -> bool:
            return stops() or self._server.is_preempt_requested()

        def move(target: float) -> None:
            with self._owned(self._server.sender, stopped, contact) as ended:
                self._driver.move_to_coordinate(target, self._polled(ended))

        try:
            move(goal.target_coordinate)
        except MotionStopped as stop:
            self._finish(self._server.set_preempted, False, stop.message)
        except AxisException as error:
            self._last_error = error.message
            rospy.logwarn("move refused or failed: %s", error)
            self._finish(self._server.set_aborted, False, error.message)
        except Exception as error:
            self._last_error = internal_error("axis", error)
            self._finish(self._server.set_aborted, False, self._last_error)
        else:
            self._last_error = None
            self._finish(self._server.set_succeeded, True)
        if contact.was_lost:
            rospy.logwarn("no contact with the client of the last move; the axis is at rest")

    def _finish(
        self, set_state: Callable[..., None], success: bool, message: Optional[Message] = None
    ) -> None:
        # The resting coordinate is published before the result, so that no client that has the
        # result still sees the axis moving.
        self._publish()
        position = self._driver.position
        result = AxisResult(
            success=success,
            coordinate=position.coordinate,
            zero_epoch=position.zero.number,
            zero_time=ros_time(position.zero.time_us),
            **(message_fields(message) if message else {}),
        )
        set_state(result, text=result.message)

    def _home(self, request: CommandRequest) -> CommandResponse:
        stopped = self._stop_since_now()
        caller = connection_header(request).get("callerid", "")
        contact = ClientContact(self._server.watch_node(caller))
        with self._owned(caller, stopped, contact) as ended:
            polled = self._polled(ended)
            return self._find_zero(lambda: self._driver.homing(polled))

    def _set_zero(self, request: CommandRequest) -> CommandResponse:
        with self._lease.use(connection_header(request).get("callerid", "")):
            return self._find_zero(self._driver.set_zero)

    def _reserve(self, request: AxisLeaseServiceRequest) -> AxisLeaseServiceResponse:
        caller = connection_header(request)["callerid"]
        number = 0
        if request.release:
            self._lease.release(caller, request.lease)
        elif request.lease:
            self._lease.renew(caller, request.lease)
            number = request.lease
        else:
            number = self._lease.reserve(caller)
        return AxisLeaseServiceResponse(success=True, lease=number, limit_s=self._lease.limit_s)

    @contextmanager
    def _owned(
        self, caller: str, stopped: Callable[[], bool], contact: ClientContact
    ) -> Iterator[Callable[[], bool]]:
        """Own the axis for a motion, and yield what ends the motion early.

        Raises:
            AxisBusyError: Another node owns the axis.
            MotionStopped: The motion was ended; the message is why.
        """
        with self._lease.use(caller) as lapsed:
            try:
                yield lambda: stopped() or contact.is_lost() or lapsed()
            except MotionStopped:
                # A requested stop counts, even if the contact was lost as well.
                if stopped():
                    raise
                if contact.was_lost:
                    raise MotionStopped(NO_CONTACT) from None
                if lapsed():
                    raise MotionStopped(self._lease.lapse) from None
                raise

    def _find_zero(self, action: Callable[[], None]) -> CommandResponse:
        try:
            action()
        except MotionStopped:
            # Somebody ended it: the axis is not homed, and nothing is wrong with it.
            self._last_error = None
            raise
        except AxisException as error:
            self._last_error = error.message
            raise
        finally:
            self._publish()
        self._last_error = None
        homed = Message(
            "homed at {coordinate:g} {unit}",
            coordinate=self._driver.current_coord,
            unit=self._unit,
        )
        return CommandResponse(success=True, **message_fields(homed))

    def _stop(self, _request: CommandRequest) -> CommandResponse:
        self._stops += 1
        return CommandResponse(success=True, **message_fields(Message("stopping")))

    def _stop_since_now(self) -> Callable[[], bool]:
        """Return a function that returns whether a stop was requested since this call."""
        # A count instead of a flag: nothing has to be cleared, so no request is lost
        # between two motions, and none remains for the next one.
        stops = self._stops
        return lambda: self._stops != stops

    def _polled(self, stop_requested: Callable[[], bool]) -> Callable[[], bool]:
        """Return what a motion asks all the time; it makes the ticks fast."""

        def polled() -> bool:
            self._moved_s = time.monotonic()
            if not self._fast:
                self._fast = True
                self._periodic.set_period(MOVING_PERIOD_S)
            return stop_requested()

        return polled

    def _tick(self) -> None:
        self._ticks += 1
        self._publish_endstop()
        moving = self._driver.moving
        if moving or not self._fast or self._ticks % RESTING_TICKS == 0:
            self._publish()
        if self._fast and not moving and time.monotonic() - self._moved_s > SOON_S:
            self._fast = False
            self._periodic.set_period(RESTING_PERIOD_S)

    def _publish_endstop(self) -> None:
        publisher, pressed = self._endstop_publisher, self._driver.endstop_pressed
        # Nearly always nobody subscribes.
        if publisher is None or pressed is None or not publisher.get_num_connections():
            return
        # In a homing the switch is closed for a few milliseconds only; each touch is shown.
        presses, self._presses = self._presses, self._driver.endstop_presses
        publisher.publish(pressed or self._presses != presses)

    def _publish(self) -> None:
        position = self._driver.position
        message = CurrentCoordinate()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = BASE_LINK
        message.coordinate = position.coordinate
        message.homed = position.homed
        message.moving = self._driver.moving
        message.zero_epoch = position.zero.number
        message.zero_time = ros_time(position.zero.time_us)
        message.owner = self._lease.owner
        self._publisher.publish(message)

    def _health(self) -> diagnostics.Health:
        lateness = self._driver.last_motion.lateness
        position = self._driver.position
        values = {
            f"coordinate [{self._unit}]": position.coordinate,
            "homed": position.homed,
            "zero": position.zero.number,
            "owner": self._lease.owner,
            "moving": self._driver.moving,
            "endstop": _endstop_state(self._driver.endstop_pressed),
            "last error": self._last_error or "",
            "pulses": self._motions.scheduling,
            "last motion [s]": f"{self._driver.last_motion.duration_s:.6f}",
            "lateness median [us]": round(lateness.median_s * 1e6),
            "lateness 99 % [us]": round(lateness.p99_s * 1e6),
            "lateness max [us]": round(lateness.max_s * 1e6),
            "edges that slowed it down": lateness.slowed,
        }
        level, message = self._state()
        return level, message, values

    def _state(self) -> Tuple[int, Message]:
        error = self._driver.failure or self._last_error
        if error:
            return diagnostics.ERROR, error
        if not self._driver.homing_done:
            return diagnostics.WARN, Message("not homed").with_fault(NOT_HOMED).as_warning()
        if self._motions.unpunctual:
            homed = Message("homed; {scheduling}", scheduling=self._motions.scheduling)
            return diagnostics.WARN, homed
        lateness = self._driver.last_motion.lateness
        if lateness.slowed:
            slowed = Message(
                "homed; {edges} late edges slowed the last motion, the latest pulse was "
                "{late_ms:.1f} ms late; reduce this computer's load",
                edges=lateness.slowed,
                late_ms=lateness.max_s * 1e3,
            )
            return diagnostics.WARN, slowed.with_fault(OVERLOADED.as_warning())
        return diagnostics.OK, Message("homed")

    def _shut_down(self) -> None:
        self._stops += 1
        self._driver.close(SHUTDOWN_LIMIT_S)
        self._server.stop_status()


def _endstop_state(pressed: Optional[bool]) -> str:
    if pressed is None:
        return ""
    return "pressed" if pressed else "open"
