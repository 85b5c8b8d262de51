"""The ROS interface of one axis, and the program that drives it over pins or a controller."""

from __future__ import annotations

import math
import os
import socket
import time
from contextlib import contextmanager
from typing import Callable, Iterator, List, Optional, Tuple

import rospy
from std_msgs.msg import Bool

from gpr20_axis_driver.controller import SILENT, ControllerMotions, open_axis
from gpr20_axis_driver.faults import AxisException, MotionStopped
from gpr20_axis_driver.high.goals import GoalServer, advertise_watched, connections_of, watch
from gpr20_axis_driver.low.pins import RobotHardware
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.axis_lease import AxisLease
from gpr20_axis_driver.mid.pulse_process import PulseProcess
from gpr20_axis_driver.motion import AxisHardware
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, OVERLOADED
from gpr20_common.high import diagnostics
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.raw_message import connection_header, ros_time
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message
from gpr20_msgs.msg import AxisAction, AxisGoal, AxisResult, CurrentCoordinate
from gpr20_msgs.srv import AxisLease as AxisLeaseService
from gpr20_msgs.srv import AxisLeaseRequest as AxisLeaseServiceRequest
from gpr20_msgs.srv import AxisLeaseResponse as AxisLeaseServiceResponse
from gpr20_msgs.srv import Command, CommandRequest, CommandResponse
from gpr20_survey.axes import BASE_LINK, AxisId, AxisParameters
from gpr20_survey.faults import NOT_HOMED

MOVING_PERIOD_S = 1.0 / 50
RESTING_PERIOD_S = 1.0 / 10
SHUTDOWN_LIMIT_S = 5.0
# How often it is looked whether a call of a controller returns [s].
WATCH_PERIOD_S = 0.5


class AxisNode:
    """Action `axis`, topic `current_coord`, services `homing`, `stop` and `lease` of one axis.

    An axis with an endstop publishes its state on the topic `endstop`; one without endstop has the
    service `set_zero`.
    """

    def __init__(self, axis_id: AxisId, parameters: AxisParameters, driver: AxisDriver) -> None:
        self._driver = driver
        self._motions = driver.motions
        self._unit = parameters.unit
        self._stops = 0
        self._last_error: Optional[Message] = None
        self._published_s = -math.inf
        self._publisher = rospy.Publisher("current_coord", CurrentCoordinate, queue_size=10)
        self._presses = self._motions.endstop_presses
        self._endstop_publisher: Optional[rospy.Publisher] = None
        if parameters.finds_zero:
            self._endstop_publisher = rospy.Publisher("endstop", Bool, queue_size=1)
        self._lease = AxisLease(parameters.lease_limit_s)
        self._server = GoalServer("axis", AxisAction, self._execute, self._lease.check)
        self._diagnostics = diagnostics.Diagnostics(self._motions.hardware.name, self._health)
        self._periodic = Periodic(RESTING_PERIOD_S, self._tick)
        rospy.on_shutdown(self._shut_down)
        self._server.start()
        self._services = [
            advertise_watched("homing", Command, self._home),
            advertise("stop", Command, self._stop),
            advertise("lease", AxisLeaseService, self._reserve),
        ]
        if not parameters.finds_zero:
            self._services.append(advertise("set_zero", Command, self._set_zero))
        self._description = publish_description(
            f"{axis_id.value}_axis/{rospy.get_name().rsplit('/', 1)[-1]}",
            self._motions.hardware,
            parameters,
        )

    def _execute(self, goal: AxisGoal) -> None:
        stops = self._stop_since_now()
        sender, connections = self._server.sender, self._server.connections

        def stopped() -> bool:
            return stops() or self._server.is_preempt_requested()

        try:
            with self._owned(sender, connections, stopped) as ended:
                self._driver.move_to_coordinate(goal.target_coordinate, ended)
        except MotionStopped as stop:
            self._finish(self._server.set_preempted, False, stop.message)
        except AxisException as error:
            self._last_error = error.message
            rospy.logwarn("move refused or failed: %s", error)
            self._finish(self._server.set_aborted, False, error.message)
        except Exception:
            self._last_error = log_fault("axis")
            self._finish(self._server.set_aborted, False, self._last_error)
        else:
            self._last_error = None
            self._finish(self._server.set_succeeded, True)

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
        with self._owned(caller, connections_of(request), stopped) as ended:
            return self._find_zero(lambda: self._driver.homing(ended))

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
        self, caller: str, connections: List[socket.socket], stopped: Callable[[], bool]
    ) -> Iterator[Callable[[], bool]]:
        """Own the axis for a motion, and yield what the motion asks all the time: whether to end.

        Raises:
            AxisBusyError: Another node owns the axis.
            MotionStopped: The motion was ended; the message is why.
        """
        is_gone = watch(connections, self._lease.limit_s)
        with self._lease.use(caller, is_gone) as why_ended:

            def ended() -> bool:
                if time.monotonic() - self._published_s >= MOVING_PERIOD_S:
                    self._publish()
                return stopped() or why_ended() is not None

            try:
                yield ended
            except MotionStopped:
                reason = why_ended()
                # A requested stop counts, even if the client is gone as well.
                if stopped() or reason is None:
                    raise
                rospy.logwarn("%s", reason)
                raise MotionStopped(reason) from None

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

    def _tick(self) -> None:
        self._publish_endstop()
        # The motion publishes by itself, but not while its process is started.
        silence_s = time.monotonic() - self._published_s
        if not self._driver.moving or silence_s >= RESTING_PERIOD_S:
            self._publish()

    def _publish_endstop(self) -> None:
        publisher, pressed = self._endstop_publisher, self._motions.endstop_pressed
        # Nearly always nobody subscribes.
        if publisher is None or pressed is None or not publisher.get_num_connections():
            return
        # In a homing the switch is closed for a few milliseconds only; each touch is shown.
        presses, self._presses = self._presses, self._motions.endstop_presses
        publisher.publish(pressed or self._presses != presses)

    def _publish(self) -> None:
        self._published_s = time.monotonic()
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
            "endstop": {None: "", True: "pressed", False: "open"}[self._motions.endstop_pressed],
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
        if self._motions.scheduling.fault_code:
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


def run_axis(build: Callable[[AxisId, AxisParameters], AxisNode]) -> None:
    """Run one axis until ROS shuts down; `build` makes its node and everything below it.

    The namespace of this node, such as x_axis, says which axis it is.
    """

    def build_own() -> AxisNode:
        group = rospy.get_namespace().rstrip("/").rsplit("/", 1)[-1]
        for axis_id in AxisId:
            if group == f"{axis_id.value}_axis":
                return build(axis_id, read_parameters(AxisParameters, group))
        raise InvalidValueError(
            Message(
                "the namespace of {node} does not name an axis; start it in x_axis, y_axis or "
                "z_axis",
                node=rospy.get_name(),
            ),
            fault=CONFIGURATION,
        )

    run_node("axis_driver", build_own)


def build_pin_axis(axis_id: AxisId, hardware: AxisHardware) -> AxisNode:
    """Build the node of an axis whose pulses are made here.

    Raises:
        Gpr20Error: The pulse process cannot be started, or the pins cannot be used.
    """
    pulses = PulseProcess(hardware)
    if pulses.scheduling.fault_code:
        rospy.logwarn(str(pulses.scheduling))
    return AxisNode(axis_id, hardware.parameters, AxisDriver(hardware.parameters, pulses))


def build_robot_axis(axis_id: AxisId, parameters: AxisParameters) -> AxisNode:
    """Build the node of an axis of the real robot.

    Raises:
        Gpr20Error: The pins, or the controller that is configured, cannot be used.
    """
    if not parameters.controller:
        return build_pin_axis(axis_id, RobotHardware(parameters))
    return AxisNode(axis_id, parameters, open_axis(parameters, watch_controller))


def watch_controller(motions: ControllerMotions) -> None:
    """End this process once a call of a controller does not return; roslaunch starts it again.

    The axis is then not homed.
    """

    def end_if_overdue() -> None:
        if motions.overdue:
            rospy.logfatal("%s", SILENT)
            os._exit(1)

    Periodic(WATCH_PERIOD_S, end_if_overdue)


def main() -> None:
    """Run one axis of the real robot."""
    run_axis(build_robot_axis)
