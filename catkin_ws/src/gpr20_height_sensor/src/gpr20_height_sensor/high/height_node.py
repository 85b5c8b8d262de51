"""The ROS interface of the height sensor."""

from __future__ import annotations

import math
import threading
import time
from typing import Collection, Optional

import rospy
from sensor_msgs.msg import Range

from gpr20_common.high import diagnostics
from gpr20_common.high.node import run_node
from gpr20_common.high.parameters import read_parameters
from gpr20_common.high.services import advertise
from gpr20_common.low.clock import Clock
from gpr20_height_sensor.errors import HeightError, HeightStoppedError
from gpr20_height_sensor.low.adc_interface import AdcInterface
from gpr20_height_sensor.low.spi_bus import SpiBus, open_spi_bus
from gpr20_height_sensor.mid.height_driver import HeightDriver, HeightMeasurement
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_msgs.srv import GetHeight, GetHeightRequest, GetHeightResponse

JOIN_LIMIT_S = 2.0


class HeightNode:
    """Service `get_height`, topic `measured_height`."""

    def __init__(self, driver: HeightDriver, hardware_id: str) -> None:
        self._driver = driver
        self._closing = threading.Event()
        self._height: Optional[HeightMeasurement] = None
        self._last_error = ""
        self._publisher = rospy.Publisher("measured_height", Range, queue_size=10)
        self._service = advertise("get_height", GetHeight, self._get_height)
        self._diagnostics = diagnostics.Diagnostics(hardware_id, self._health)
        # Measures beside the service: both only share the bus, for one reading at a time.
        self._thread = threading.Thread(target=self._publish_heights, name="measured_height")
        rospy.on_shutdown(self._shut_down)
        self._thread.start()

    def _get_height(self, _request: GetHeightRequest) -> GetHeightResponse:
        try:
            measured = self._driver.measure()
        except HeightError as error:
            rospy.logwarn("get_height refused: %s", error)
            # NaN, because a zero could be taken for a height.
            return GetHeightResponse(
                success=False, message=str(error), height_m=math.nan, spread_m=math.nan
            )
        return GetHeightResponse(
            success=True,
            height_m=measured.height_m,
            spread_m=measured.spread_m,
            samples=measured.samples,
            measured=_ros_time(measured.measured_us),
        )

    def _publish_heights(self) -> None:
        period_s = 1.0 / self._driver.parameters.publish_rate_hz
        next_s = time.monotonic()
        while not self._closing.wait(max(0.0, next_s - time.monotonic())):
            next_s = time.monotonic() + period_s
            try:
                self._height, self._last_error = self._driver.measure(), ""
            except HeightStoppedError:
                return
            except HeightError as error:
                self._height, self._last_error = None, str(error)
            self._publish(self._height)

    def _publish(self, measured: Optional[HeightMeasurement]) -> None:
        parameters = self._driver.parameters
        message = Range()
        message.header.stamp = _ros_time(measured.measured_us) if measured else rospy.Time.now()
        message.header.frame_id = parameters.frame_id
        message.radiation_type = Range.INFRARED
        message.field_of_view = parameters.field_of_view_rad
        message.min_range = parameters.min_distance_m + parameters.height_offset_m
        message.max_range = parameters.max_distance_m + parameters.height_offset_m
        # NaN says that there is no valid height now; the diagnostics say why.
        message.range = measured.height_m if measured else math.nan
        self._publisher.publish(message)

    def _health(self) -> diagnostics.Health:
        height, last_error = self._height, self._last_error
        values = {
            "height [m]": f"{height.height_m:.4f}" if height else "none",
            "spread [m]": f"{height.spread_m:.4f}" if height else "none",
            "last error": last_error,
        }
        if last_error:
            return diagnostics.ERROR, last_error, values
        if height is None:
            return diagnostics.WARN, "no height measured yet", values
        return diagnostics.OK, f"height {height.height_m:.3f} m", values

    def _shut_down(self) -> None:
        self._closing.set()
        self._driver.shut_down()
        self._thread.join(JOIN_LIMIT_S)


def _ros_time(time_us: int) -> rospy.Time:
    return rospy.Time(time_us // 1_000_000, time_us % 1_000_000 * 1000)


def _time_of_day_us() -> int:
    return time.time_ns() // 1000


def build_height_node(
    parameters: HeightParameters, spi: SpiBus, clock: Clock, hardware_id: str
) -> HeightNode:
    """Build the node from the bottom up.

    Args:
        parameters: Parameters of the sensor.
        spi: The bus on which the converter is.
        clock: Spaces the readings.
        hardware_id: What the diagnostics call the hardware.

    Raises:
        Gpr20Error: A parameter is not allowed.
    """
    adc = AdcInterface(spi, parameters.channel)
    return HeightNode(HeightDriver(adc, parameters, clock, _time_of_day_us), hardware_id)


def read_height_parameters(others: Collection[str] = ()) -> HeightParameters:
    """Return the node's parameters.

    Args:
        others: Parameters of the node that are not the sensor's.

    Raises:
        Gpr20Error: A parameter is not allowed.
    """
    return read_parameters(HeightParameters, others=others)


def main() -> None:
    """Run the height sensor of the real robot."""

    def build() -> HeightNode:
        parameters = read_height_parameters()
        spi = open_spi_bus(parameters.spi_bus, parameters.spi_device, parameters.spi_speed_hz)
        return build_height_node(parameters, spi, Clock(), "GP2Y0A21YK0F on MCP3008")

    run_node("height_sensor", build)
