#!/usr/bin/env python3
"""A client that begins something and waits for its end: to be killed in the middle.

Usage: axis_client.py AXIS home|TARGET
"""

import sys

import actionlib
import rospy
from std_srvs.srv import Trigger

from gpr20_msgs.msg import AxisAction, AxisGoal

LIMIT_S = 20.0

rospy.init_node("axis_client", anonymous=True)
group, what = f"{sys.argv[1]}_axis", sys.argv[2]
client = actionlib.SimpleActionClient(f"{group}/axis", AxisAction)
assert client.wait_for_server(rospy.Duration(LIMIT_S))
if what == "home":
    rospy.ServiceProxy(f"{group}/homing", Trigger)()
else:
    client.send_goal(AxisGoal(target_coordinate=float(what)))
    client.wait_for_result()
