"""One axis for tests: client, processes, and the true state."""

import subprocess
import sys
import threading
import time
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import rosgraph
import rosnode
import rospy

from gpr20_msgs.msg import AxisAction, AxisGoal, CurrentCoordinate
from gpr20_msgs.srv import Command
from gpr20_simulator.high.simulated_robot import shared_state_path
from gpr20_simulator.low.shared_state import open_shared_state

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
        self.name = name
        self.group = f"{name.value}_axis"
        self.last = None
        self.readings = []
        self.received = threading.Event()
        self.subscriber = rospy.Subscriber(
            f"{self.group}/current_coord", CurrentCoordinate, self._receive
        )
        self.connect()
        # Only now: the first process that opens it sets where the carriage begins.
        self.world = open_shared_state(shared_state_path("/"))

    def _receive(self, message):
        self.last = message
        self.readings.append(message)
        self.received.set()

    def connect(self):
        """Wait for the node, which may have been restarted."""
        self.client = actionlib.SimpleActionClient(f"{self.group}/axis", AxisAction)
        assert self.client.wait_for_server(rospy.Duration(LIMIT_S))
        self.received.clear()
        assert self.received.wait(LIMIT_S)

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
        deadline_s = time.monotonic() + LIMIT_S
        while self.client.gh.get_comm_state() != actionlib.CommState.DONE:
            assert time.monotonic() < deadline_s, "the goal never ended"
            time.sleep(0.005)
        return self.client.gh.get_goal_status(), self.client.gh.get_result()

    @property
    def last_zero(self):
        """Number and time of the zero of the next reading."""
        self.received.clear()
        assert self.received.wait(LIMIT_S)
        return (self.last.zero_epoch, self.last.zero_time.to_nsec())

    @property
    def steps(self):
        return self.world.steps(self.name)

    @property
    def last_pulse_ns(self):
        return self.world.last_pulse_ns(self.name)

    @property
    def pins_low(self):
        return self.world.pins_low(self.name)

    @property
    def node_pid(self):
        name = rospy.resolve_name(f"{self.group}/axis_driver")
        server = rosnode.get_api_uri(rosgraph.Master(rospy.get_name()), name, skip_cache=True)
        return ServerProxy(server).getPid(rospy.get_name())[2]

    @property
    def pulse_pid(self):
        """The process that makes the pulses: the node's only child."""
        (child,) = children(self.node_pid)
        return child

    def begin_move(self, target):
        """Begin a move; return when the axis has moved by some steps and the client knows of it.

        The carriage can be ahead of the client. A goal that is cancelled before its client has
        received its active status ends as LOST there: a status that was sent before the goal
        arrived does not contain it.
        """
        before = self.steps
        self.client.send_goal(AxisGoal(target_coordinate=target))
        wait_until(lambda: abs(self.steps - before) > 10)
        wait_until(lambda: self.client.gh.get_comm_state() == actionlib.CommState.ACTIVE)


def start_client(axis, *what):
    """Start a client that begins something."""
    script = str(Path(__file__).with_name("axis_client.py"))
    return subprocess.Popen([sys.executable, script, axis.name.value, *what], stdin=subprocess.PIPE)


def killed_client(axis, what, begun):
    """Let a client begin something, kill it, and return when it was killed [ns]."""
    client = start_client(axis, what)
    wait_until(begun)
    client.kill()
    killed_ns = time.monotonic_ns()
    client.wait()
    return killed_ns


def children(parent_pid):
    """The processes whose parent this is; a process that ends meanwhile is left out."""
    found = []
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            fields = dict(line.split(":", 1) for line in status.read_text().splitlines())
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(fields["PPid"]) == parent_pid:
            found.append(int(fields["Pid"]))
    return found


def exists(pid):
    return Path(f"/proc/{pid}").exists()
