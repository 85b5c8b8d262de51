"""One number inside messages of any type; what does not fit is named."""

import math

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.faults import CONFIGURATION

pytest.importorskip("sensor_msgs.msg")

from sensor_msgs.msg import BatteryState, Imu
from std_msgs.msg import Bool, Float64, Float64MultiArray, UInt8MultiArray

from gpr20_main_control.high.sensor_topics import MessageField

MISSING, UNKNOWN = CONFIGURATION, CONFIGURATION


@each_case(
    "message, path, value",
    [
        (Float64(0.25), "data", 0.25),
        (Bool(True), "data", 1.0),
        (BatteryState(cell_voltage=[3.5, 3.75]), "cell_voltage[1]", 3.75),
        (UInt8MultiArray(data=bytes([7, 9])), "data[1]", 9.0),
        (Imu(orientation_covariance=[2.0] * 9), "orientation_covariance[8]", 2.0),
        (Imu(), "angular_velocity.z", 0.0),
        (Float64MultiArray(), "data[3]", math.nan),
    ],
)
def test_the_number_is_found(message, path, value):
    found = MessageField(message._type, path).read(message)
    assert found == value or (math.isnan(found) and math.isnan(value))


@each_case(
    "datatype, path, fault, shown",
    [
        ("std_msgs/Float64", "value", MISSING, "data (float64)"),
        ("sensor_msgs/Imu", "angular_velocity.w", MISSING, "x (float64), y (float64)"),
        ("sensor_msgs/Imu", "angular_velocity", MISSING, "y (float64)"),
        ("std_msgs/Header", "stamp", MISSING, "stamp (time)"),
        ("std_msgs/Float64", "data[0]", MISSING, "data (float64)"),
        ("std_msgs/Float64MultiArray", "data", MISSING, "data[0]"),
        ("no_such_package/Float64", "data", UNKNOWN, "no_such_package/Float64"),
        ("std_msgs/NoSuchType", "data", UNKNOWN, "std_msgs/NoSuchType"),
    ],
)
def test_a_field_that_is_not_there_is_named_with_those_that_are(datatype, path, fault, shown):
    with raises_fault(fault, shown):
        MessageField(datatype, path)
