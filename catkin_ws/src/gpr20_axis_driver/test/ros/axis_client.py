#!/usr/bin/env python3
"""A client that begins something and waits for its end: to be killed in the middle.

Usage: axis_client.py AXIS home|TARGET
       axis_client.py AXIS TARGET unplugged
       axis_client.py AXIS leased [TARGET]

Leased, it reserves the axis first and renews that.
Unplugged, it vanishes without a word at the first line of its input and comes back at the next.
"""

import sys
import time
from pathlib import Path

import actionlib
import rospy

from gpr20_msgs.msg import AxisAction, AxisGoal
from gpr20_msgs.srv import AxisLease, Command

LIMIT_S = 60.0

rospy.init_node("axis_client", anonymous=True)
group, what = f"{sys.argv[1]}_axis", sys.argv[2]
client = actionlib.SimpleActionClient(f"{group}/axis", AxisAction)
assert client.wait_for_server(rospy.Duration(LIMIT_S))


def move(target):
    client.send_goal(AxisGoal(target_coordinate=target))
    wait_for_end()


def wait_for_end():
    # Not by wait_for_result, which waits for ever for a result that arrives too early.
    deadline_s = time.monotonic() + LIMIT_S
    while client.gh.get_comm_state() != actionlib.CommState.DONE:
        assert time.monotonic() < deadline_s, "the goal never ended"
        time.sleep(0.005)


if what == "home":
    rospy.ServiceProxy(f"{group}/homing", Command)()
elif "unplugged" in sys.argv:
    sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "gpr20_common/test/unit"))
    from vanishing_peer import come_back, vanish

    client.send_goal(AxisGoal(target_coordinate=float(what)))
    for change in (vanish, come_back):
        sys.stdin.readline()
        action = client.action_client
        for topic in (action.pub_goal, action.status_sub):
            for connection in topic.impl.connections:
                change(connection.socket)
    wait_for_end()
    move(1.0)
elif what == "leased":
    lease = rospy.ServiceProxy(f"{group}/lease", AxisLease)
    held = lease()
    assert held.success, held.message
    rospy.Timer(rospy.Duration(held.limit_s / 8), lambda _event: lease(lease=held.lease))
    if len(sys.argv) > 3:
        move(float(sys.argv[3]))
    rospy.spin()
else:
    move(float(what))
