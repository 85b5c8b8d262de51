#!/usr/bin/env python3
"""A client that begins something and waits for its end: to be killed in the middle.

Usage: axis_client.py AXIS home|TARGET
       axis_client.py AXIS TARGET unplugged

Unplugged, it vanishes without a word at the first line of its input and comes back at the next.
"""

import sys
from pathlib import Path

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
elif "unplugged" in sys.argv:
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit"))
    from vanishing_peer import come_back, vanish

    client.send_goal(AxisGoal(target_coordinate=float(what)))
    for change in (vanish, come_back):
        sys.stdin.readline()
        for connection in client.action_client.pub_goal.impl.connections:
            change(connection.socket)
    client.wait_for_result()
    client.send_goal_and_wait(AxisGoal(target_coordinate=1.0))
else:
    client.send_goal(AxisGoal(target_coordinate=float(what)))
    client.wait_for_result()
