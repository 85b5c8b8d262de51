"""The life of a node: start, say clearly what is wrong, run, end."""

from __future__ import annotations

import os
import sys
import threading
from typing import Any, Callable, Type, TypeVar

import rosgraph
import rospy

from gpr20_common.errors import Gpr20Error, NodeSilentError
from gpr20_common.high.connection_keeper import ConnectionKeeper
from gpr20_common.high.parameters import (
    configuration_name,
    read_parameters,
    refuse_private_parameters,
)
from gpr20_common.low.line_output import enable_line_buffering
from gpr20_common.low.node_probe import NodeProbe
from gpr20_common.low.roslaunch_process import end_with_roslaunch, roslaunch_number
from gpr20_common.low.thread_fault import end_with_thread
from gpr20_common.terminal_text import say

# A node of the same name that lives answers within this time [s].
ANSWER_LIMIT_S = 1.0

Parameters = TypeVar("Parameters")


def run_node(name: str, build: Callable[[], Any], needed: bool = True) -> None:
    """Run a node until ROS shuts down.

    A node whose name is taken by one that lives is not started: ROS would end the other one,
    and of two launches on one master each would end the other's nodes for ever. Its launch ends,
    because its robot would be incomplete.

    Until the node has started, a signal ends it at once, as the programs in `nodes/` set it.

    Args:
        name: Default name of the node.
        build: Reads the parameters, builds the objects and connects them. What it
            returns is kept for the life of the node.
        needed: Whether its launch ends if it cannot start; else it is started again and again.
    """
    enable_line_buffering()
    threading.excepthook = end_with_thread
    _refuse_second(_full_name(name), needed)
    try:
        # Its handlers end the node in the main thread, which has locks of rospy while it starts.
        # A robot's time is real, whatever /use_sim_time says: without a /clock all would be 0.
        rospy.init_node(name, disable_rostime=True, disable_signals=True)
    except rospy.ROSInitException as error:
        say(f"{name} was ended before it had started: {error}", file=sys.stderr)
        # At once: rospy's own threads may wait for a master that is gone.
        os._exit(1)
    try:
        if not configuration_name():
            refuse_private_parameters()
        kept = build()
    except Gpr20Error as error:
        rospy.logfatal("%s cannot start: %s", rospy.get_name(), error)
        if needed:
            _end_first_launch()
        sys.exit(1)
    if configuration_name():
        rospy.set_param(_started_name(), True)
    keeper = ConnectionKeeper()
    rospy.loginfo("%s is ready", rospy.get_name())
    rospy.core.register_signals()
    rospy.spin()
    del kept, keeper


def run_device(
    name: str,
    parameter_class: Type[Parameters],
    build: Callable[[Parameters], Any],
    section: str = "",
    needed: bool = True,
) -> None:
    """Run the node of one device until ROS shuts down.

    Args:
        name: Default name of the node.
        parameter_class: Dataclass of the device's parameters.
        build: Builds the node from its parameters. What it returns is kept for its life.
        section: Part of the configuration that holds the parameters; empty: named like the node.
        needed: Whether its launch ends if it cannot start; else it is started again and again.
    """
    run_node(name, lambda: build(read_parameters(parameter_class, section or name)), needed)


def _end_first_launch() -> None:
    """End the launch if this node has never started in it: starting again would fail again.

    A node that ran before, whose hardware is gone, is started again by roslaunch until the
    hardware is back; the survey waits meanwhile.
    """
    launch = roslaunch_number() if configuration_name() else None
    if launch is not None and not rospy.has_param(_started_name()):
        rospy.logfatal("%s ends the launch, because it cannot start", rospy.get_name())
        end_with_roslaunch(launch)


def _started_name() -> str:
    return f"/gpr20_started{configuration_name()}{rospy.get_name()}"


def _full_name(name: str) -> str:
    given = rosgraph.names.load_mappings(sys.argv).get("__name", name)
    return str(rosgraph.names.resolve_name(given, rosgraph.names.get_ros_namespace() + "node"))


def _refuse_second(name: str, needed: bool) -> None:
    probe = NodeProbe(rosgraph.get_master_uri(), name, name, ANSWER_LIMIT_S)
    try:
        process = probe.process()
    except NodeSilentError:
        return  # there is none, or it has died and left its name behind
    say(
        f"{name} cannot start: it is already running (process {process}). If this is a second "
        "launch of the robot, end the first one, or give this one its own namespace, such as "
        "ns:=robot2",
        file=sys.stderr,
    )
    launch = roslaunch_number() if needed and configuration_name() else None
    if launch is not None:
        say(f"{name} ends the launch, because it cannot start", file=sys.stderr)
        end_with_roslaunch(launch)
    sys.exit(1)
