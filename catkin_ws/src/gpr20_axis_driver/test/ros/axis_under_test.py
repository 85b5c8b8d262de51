"""One axis for tests, with its true state; as a program, another client of it.

The program begins something and waits for its end, to be killed in the middle:
axis_under_test.py AXIS home | TARGET | TARGET unplugged | leased

Leased, it reserves the axis and renews that. Unplugged, it vanishes without a word at the first
line of its input and comes back at the next.
"""

import subprocess
import sys
import threading
import time
from pathlib import Path

import actionlib
import rospy

from gpr20_msgs.msg import AxisAction, AxisGoal, CurrentCoordinate
from gpr20_msgs.srv import AxisLease, Command
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes.axis_id import AxisId

sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_common/test/unit"))

from vanishing_peer import come_back, vanish

LIMIT_S = 60.0


def wait_until(condition):
    """Return once the condition holds."""
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, "the condition never held"
        time.sleep(0.005)


class Axis:
    """One axis as a client sees it, and its true state."""

    def __init__(self, name):
        self.name, self.group = name, f"{name.value}_axis"
        self.last = None
        self.received = threading.Event()
        topic = f"{self.group}/current_coord"
        self.subscriber = rospy.Subscriber(topic, CurrentCoordinate, self._receive)
        self.client = actionlib.SimpleActionClient(f"{self.group}/axis", AxisAction)
        assert self.client.wait_for_server(rospy.Duration(LIMIT_S))
        assert self.received.wait(LIMIT_S)
        # Only now: the first process that opens it sets where the carriage begins.
        self.world = open_shared_state(shared_state_path("/"))

    def _receive(self, message):
        self.last = message
        self.received.set()

    @property
    def steps(self):
        return self.world.steps(self.name)

    def call(self, service):
        rospy.wait_for_service(f"{self.group}/{service}", LIMIT_S)
        return rospy.ServiceProxy(f"{self.group}/{service}", Command)()

    def home(self):
        response = self.call("homing")
        assert response.success, response.message

    def move(self, target):
        self.client.send_goal(AxisGoal(target_coordinate=target))
        return self.finish()

    def finish(self):
        """Wait for the end; return (terminal state, result).

        Not by wait_for_result: SimpleActionClient loses a result that arrives before it has
        stored the goal's handle, and would wait for ever.
        """
        wait_until(lambda: self.client.gh.get_comm_state() == actionlib.CommState.DONE)
        return self.client.gh.get_goal_status(), self.client.gh.get_result()

    def begin_move(self, target):
        """Begin a move; return when the axis has moved by some steps and the client knows of it.

        The carriage can be ahead of the client. A goal that is cancelled before its client has
        received its active status ends as LOST there: a status that was sent before the goal
        arrived does not contain it.
        """
        before = self.steps
        self.client.send_goal(AxisGoal(target_coordinate=target))
        wait_until(lambda: abs(self.steps - before) > 10 and self.last.moving)
        wait_until(lambda: self.client.gh.get_comm_state() == actionlib.CommState.ACTIVE)

    def vanish_and_come_back(self):
        action = self.client.action_client
        for change in (vanish, come_back):
            sys.stdin.readline()
            for topic in (action.pub_goal, action.status_sub):
                for connection in topic.impl.connections:
                    change(connection.socket)

    def hold(self):
        lease = rospy.ServiceProxy(f"{self.group}/lease", AxisLease)
        held = lease()
        assert held.success, held.message
        rospy.Timer(rospy.Duration(held.limit_s / 8), lambda _event: lease(lease=held.lease))


def start_client(axis, *what):
    """Start another client, which begins something."""
    arguments = [sys.executable, __file__, axis.name.value, *what]
    return subprocess.Popen(arguments, stdin=subprocess.PIPE)


def end_client(client):
    client.kill()
    client.communicate()


def main(name, what, unplugged=""):
    rospy.init_node("axis_client", anonymous=True)
    if what == "home":
        # As rosservice does: its connection to the service is all that there is.
        rospy.ServiceProxy(f"{name}_axis/homing", Command)()
        return
    axis = Axis(AxisId(name))
    if what == "leased":
        axis.hold()
        rospy.spin()
    elif unplugged:
        axis.client.send_goal(AxisGoal(target_coordinate=float(what)))
        axis.vanish_and_come_back()
        axis.finish()
        axis.move(1.0)
    else:
        axis.move(float(what))


if __name__ == "__main__":
    main(*sys.argv[1:])
