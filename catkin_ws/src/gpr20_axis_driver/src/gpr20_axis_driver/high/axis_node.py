"""The ROS interface of one axis."""

from __future__ import annotations

from typing import Callable, Collection, Optional

import actionlib
import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from gpr20_axis_driver.axis_exceptions import AxisException, MotionStopped
from gpr20_axis_driver.low.endstop_interface import EndstopInterface
from gpr20_axis_driver.low.pins import Pins, raspberry_pi_pins
from gpr20_axis_driver.low.stepper_interface import StepperInterface
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.axis_parameters import AxisParameters
from gpr20_common.high import diagnostics
from gpr20_common.high.node import run_node
from gpr20_common.high.parameters import read_parameters
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.services import advertise
from gpr20_common.low.clock import Clock
from gpr20_msgs.msg import AxisAction, AxisGoal, AxisResult, CurrentCoordinate

MOVING_RATE_HZ = 50
# At rest every fifth tick is published: 10 Hz.
RESTING_TICKS = 5
SHUTDOWN_LIMIT_S = 5.0


class AxisNode:
    """Action `axis`, topic `current_coord`, services `homing` and `stop` of one axis."""

    def __init__(self, driver: AxisDriver, unit: str, hardware_id: str) -> None:
        self._driver = driver
        self._unit = unit
        self._stops = 0
        self._last_error = ""
        self._ticks = 0
        self._publisher = rospy.Publisher("current_coord", CurrentCoordinate, queue_size=10)
        self._server = actionlib.SimpleActionServer(
            "axis", AxisAction, execute_cb=self._execute, auto_start=False
        )
        self._services = [
            advertise("homing", Trigger, self._home),
            advertise("stop", Trigger, self._stop),
        ]
        self._diagnostics = diagnostics.Diagnostics(hardware_id, self._health)
        self._periodic = Periodic(1.0 / MOVING_RATE_HZ, self._tick)
        rospy.on_shutdown(self._shut_down)
        self._server.start()

    def _execute(self, goal: AxisGoal) -> None:
        stopped = self._stop_since_now()
        try:
            self._driver.move_to(
                goal.target_coordinate,
                lambda: stopped() or self._server.is_preempt_requested(),
            )
        except MotionStopped as stop:
            self._finish(self._server.set_preempted, False, str(stop))
        except AxisException as error:
            self._last_error = str(error)
            rospy.logwarn("move refused or failed: %s", error)
            self._finish(self._server.set_aborted, False, str(error))
        else:
            self._last_error = ""
            self._finish(self._server.set_succeeded, True, "")

    def _finish(self, set_state: Callable[..., None], success: bool, message: str) -> None:
        # The resting coordinate goes out before the result, so that nobody who has the
        # result still sees the axis moving.
        self._publish()
        set_state(AxisResult(success, message, self._driver.coordinate), text=message)

    def _home(self, _request: TriggerRequest) -> TriggerResponse:
        try:
            self._driver.home(self._stop_since_now())
        except AxisException as error:
            self._last_error = str(error)
            raise
        finally:
            self._publish()
        self._last_error = ""
        return TriggerResponse(True, f"homed at {self._driver.coordinate:g} {self._unit}")

    def _stop(self, _request: TriggerRequest) -> TriggerResponse:
        self._stops += 1
        return TriggerResponse(True, "stopping")

    def _stop_since_now(self) -> Callable[[], bool]:
        """Return what tells a motion that begins now whether to stop."""
        # A count instead of a flag: nothing has to be cleared, so no request is lost
        # between two motions, and none is left over for the next one.
        stops = self._stops
        return lambda: self._stops != stops

    def _tick(self) -> None:
        self._ticks += 1
        if self._driver.moving or self._ticks % RESTING_TICKS == 0:
            self._publish()

    def _publish(self) -> None:
        message = CurrentCoordinate()
        message.header.stamp = rospy.Time.now()
        message.coordinate = self._driver.coordinate
        message.homed = self._driver.homed
        message.moving = self._driver.moving
        self._publisher.publish(message)

    def _health(self) -> diagnostics.Health:
        values = {
            f"coordinate [{self._unit}]": self._driver.coordinate,
            "homed": self._driver.homed,
            "moving": self._driver.moving,
            "last error": self._last_error,
        }
        if self._last_error:
            return diagnostics.ERROR, self._last_error, values
        if not self._driver.homed:
            return diagnostics.WARN, "not homed", values
        return diagnostics.OK, "homed", values

    def _shut_down(self) -> None:
        self._stops += 1
        self._driver.close(SHUTDOWN_LIMIT_S)


def build_axis_node(
    pins_of: Callable[[AxisParameters], Pins],
    clock: Clock,
    hardware_id: str,
    other_parameters: Collection[str] = (),
) -> AxisNode:
    """Read the node's parameters and build an axis from the bottom up.

    Args:
        pins_of: Gives the pins that an axis with these parameters is wired to.
        clock: Decides how long a second takes.
        hardware_id: What the diagnostics call the hardware.
        other_parameters: Parameters of the node that are not the axis's.

    Raises:
        Gpr20Error: A parameter is not allowed, or the pins cannot be used.
    """
    parameters = read_parameters(AxisParameters, others=other_parameters)
    pins = pins_of(parameters)
    stepper = StepperInterface(pins, parameters.dir_pin, parameters.step_pin, clock)
    endstop: Optional[EndstopInterface] = None
    if parameters.sensor_pin is not None:
        endstop = EndstopInterface(pins, parameters.sensor_pin)
    return AxisNode(AxisDriver(parameters, stepper, endstop, clock), parameters.unit, hardware_id)


def main() -> None:
    """Run one axis of the real robot."""
    run_node(
        "axis_driver",
        lambda: build_axis_node(lambda _parameters: raspberry_pi_pins(), Clock(), "DRV8825"),
    )
