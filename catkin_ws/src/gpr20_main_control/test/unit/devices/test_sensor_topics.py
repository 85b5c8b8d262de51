"""One number inside messages of any type; what does not fit is named."""

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.faults import CONFIGURATION

pytest.importorskip("sensor_msgs.msg")

import rospy
from sensor_msgs.msg import BatteryState, Imu
from std_msgs.msg import Bool, Float64, Float64MultiArray, String, UInt8MultiArray

from gpr20_common.high.raw_message import serialized
from gpr20_main_control.high.sensor_topics import MessageField

MISSING, UNKNOWN = CONFIGURATION, CONFIGURATION


def received(message):
    """Return a message as it arrives at a subscriber of any type."""
    found = rospy.AnyMsg()
    found.deserialize(serialized(message))
    found._connection_header = {"type": message._type, "md5sum": message._md5sum}
    return found


@each_case(
    "message, path, value",
    [
        (Float64(0.25), "data", 0.25),
        (Bool(True), "data", 1.0),
        (BatteryState(cell_voltage=[3.5, 3.75]), "cell_voltage[1]", 3.75),
        (UInt8MultiArray(data=bytes([7, 9])), "data[1]", 9.0),
        (Imu(orientation_covariance=[2.0] * 9), "orientation_covariance[8]", 2.0),
        (Imu(), "angular_velocity.z", 0.0),
    ],
)
def test_the_number_is_found(message, path, value):
    assert MessageField(message._type, path).read(received(message)) == value


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


def test_messages_of_another_type_are_named():
    with raises_fault(CONFIGURATION, "std_msgs/String", "std_msgs/Float64"):
        MessageField("std_msgs/Float64", "data").read(received(String("1")))


def test_damaged_and_short_messages_are_refused():
    damaged = received(Float64(1.0))
    damaged._buff = damaged._buff[:-1]
    with raises_fault(MISSING, "data"):
        MessageField("std_msgs/Float64", "data").read(damaged)
    with raises_fault(MISSING, "data[3]"):
        MessageField("std_msgs/Float64MultiArray", "data[3]").read(received(Float64MultiArray()))
