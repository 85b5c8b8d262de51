"""The ROS interface of the height sensor."""

from __future__ import annotations

import math
import os
from typing import Optional

import rospy
from sensor_msgs.msg import Range

from gpr20_common.high import diagnostics
from gpr20_common.high.answers import advertise, message_fields
from gpr20_common.high.node import publish_description, read_parameters, run_node
from gpr20_common.high.periodic import Periodic
from gpr20_common.high.raw_message import ros_time
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_height_sensor.adc_interface import AdcInterface, SpiBus, open_spi_bus
from gpr20_height_sensor.faults import HeightError, HeightStoppedError
from gpr20_height_sensor.height_driver import HeightDriver, HeightMeasurement, HeightParameters
from gpr20_msgs.srv import GetHeight, GetHeightRequest, GetHeightResponse
from gpr20_survey.axes import HEIGHT_SENSOR_LINK
from gpr20_survey.faults import HEIGHT_NOT_MEASURED

NODE = "height_sensor"
WATCH_PERIOD_S = 0.5
# Opening of the sensor's beam [rad], for display only.
BEAM_RAD = 0.05


class HeightNode:
    """Service `get_height`, topic `measured_height`."""

    def __init__(self, driver: HeightDriver, hardware: Hardware) -> None:
        self._driver = driver
        self._height: Optional[HeightMeasurement] = None
        self._voltage_v = math.nan
        self._last_error: Optional[Message] = None
        self._publisher = rospy.Publisher("measured_height", Range, queue_size=10)
        self._service = advertise("get_height", GetHeight, self._get_height)
        self._diagnostics = diagnostics.Diagnostics(hardware.name, self._health)
        self._description = publish_description(NODE, hardware, driver.parameters)
        # Ends the measurement under way; `Periodic` then waits for its end.
        rospy.on_shutdown(driver.shut_down)
        # Measures in parallel with the service: they share only the bus, one reading at a time.
        self._periodic = Periodic(1.0 / driver.parameters.publish_rate_hz, self._publish_height)

    def _get_height(self, _request: GetHeightRequest) -> GetHeightResponse:
        voltage_v = math.nan
        try:
            readings = self._driver.take_readings()
            voltage_v = readings.voltage_v
            measured = self._driver.height_from(readings)
        except HeightError as error:
            rospy.logwarn("get_height refused: %s", error)
            # NaN, because a zero could be taken for a height.
            return GetHeightResponse(
                success=False,
                height_m=math.nan,
                spread_m=math.nan,
                voltage_v=voltage_v,
                **message_fields(error.message),
            )
        return GetHeightResponse(
            success=True,
            height_m=measured.height_m,
            spread_m=measured.spread_m,
            voltage_v=voltage_v,
        )

    def _publish_height(self) -> None:
        voltage_v, measured = math.nan, None
        try:
            readings = self._driver.take_readings()
            voltage_v = readings.voltage_v
            measured, self._last_error = self._driver.height_from(readings), None
        except HeightStoppedError:
            return
        except HeightError as error:
            self._last_error = error.message
        self._height, self._voltage_v = measured, voltage_v
        parameters = self._driver.parameters
        message = Range()
        message.header.stamp = ros_time(measured.measured_us) if measured else rospy.Time.now()
        message.header.frame_id = HEIGHT_SENSOR_LINK
        message.radiation_type = Range.INFRARED
        message.field_of_view = BEAM_RAD
        message.min_range = parameters.min_distance_m + parameters.height_offset_m
        message.max_range = parameters.max_distance_m + parameters.height_offset_m
        # NaN means that there is no valid height now; the diagnostics report the reason.
        message.range = measured.height_m if measured else math.nan
        self._publisher.publish(message)

    def _health(self) -> diagnostics.Health:
        height, last_error = self._height, self._last_error
        values = {
            "height [m]": f"{height.height_m:.4f}" if height else "none",
            "spread [m]": f"{height.spread_m:.4f}" if height else "none",
            "voltage [V]": f"{self._voltage_v:.4f}",
            "last error": last_error or "",
        }
        if last_error:
            return diagnostics.ERROR, last_error, values
        if height is None:
            message = Message("no height measured yet").with_fault(HEIGHT_NOT_MEASURED)
            return diagnostics.WARN, message, values
        return diagnostics.OK, Message("height {height_m:.3f} m", height_m=height.height_m), values


def build_height_node(
    parameters: HeightParameters, spi: SpiBus, clock: Clock, hardware: Hardware
) -> HeightNode:
    """Build the node and everything below it; `clock` spaces the readings."""
    adc = AdcInterface(spi, parameters.channel)

    def end_if_overdue() -> None:
        # Nothing else ends such a call; roslaunch starts this node again.
        if adc.overdue:
            rospy.logfatal("the bus of the height sensor does not return from a call")
            os._exit(1)

    Periodic(WATCH_PERIOD_S, end_if_overdue)
    return HeightNode(HeightDriver(adc, parameters, clock), hardware)


def build_robot_node(parameters: HeightParameters) -> HeightNode:
    """Build the node over the SPI bus of the robot's computer."""
    spi = open_spi_bus(parameters.spi_bus, parameters.spi_device, parameters.spi_speed_hz)
    return build_height_node(parameters, spi, Clock(), Hardware("GP2Y0A21YK0F on MCP3008"))


def main() -> None:
    """Run the height sensor of the real robot."""
    run_node(NODE, lambda: build_robot_node(read_parameters(HeightParameters, NODE)))
