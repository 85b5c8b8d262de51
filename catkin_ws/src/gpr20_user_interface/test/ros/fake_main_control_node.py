#!/usr/bin/env python3
"""The fake main_control as a node of its own, for tests that take its master away."""

import rospy
from fake_main_control import FakeMainControl

rospy.init_node("main_control")
fake = FakeMainControl("")
rospy.spin()
