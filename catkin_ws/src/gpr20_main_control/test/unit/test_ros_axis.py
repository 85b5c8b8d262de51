"""An axis over ROS, without a graph: what a stop does to a homing whose node is away."""

import threading

import pytest

pytest.importorskip("actionlib")
pytest.importorskip("gpr20_msgs.msg")

import rospy
from fake_robot import LIMIT_S

from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.high import ros_axis
from gpr20_main_control.mid.serial_calls import in_background


def test_a_homing_that_waits_for_its_node_is_not_begun_after_a_stop(monkeypatch):
    waiting, node_is_back = threading.Event(), threading.Event()
    called = []

    def wait_for_service(name, timeout):
        if name.endswith("homing"):
            waiting.set()
            node_is_back.wait(LIMIT_S)

    monkeypatch.setattr(rospy, "wait_for_service", wait_for_service)
    monkeypatch.setattr(rospy, "ServiceProxy", lambda name, _class: lambda: called.append(name))
    monkeypatch.setattr(rospy, "Subscriber", lambda *_arguments, **_options: None)
    monkeypatch.setattr(ros_axis.actionlib, "ActionClient", lambda *_arguments: None)
    axis = ros_axis.RosAxis("x_axis", Clock())
    homing = in_background(lambda: axis.home(LIMIT_S))
    assert waiting.wait(LIMIT_S)
    axis.stop()
    node_is_back.set()
    with pytest.raises(DeviceError, match="given up"):
        homing.result(LIMIT_S)
    assert "x_axis/homing" not in called
