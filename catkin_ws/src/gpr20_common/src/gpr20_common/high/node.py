"""The life of a node: its parameters, start, say clearly what is wrong, describe itself, run, end.

A launch keeps its whole configuration, as JSON, under a name of its own (package `gpr20_launch`)
and hands that name to each node as the argument `configuration:=NAME`. So a node that restarts has
the same, whatever was launched beside it meanwhile. Without the argument it has the defaults.
"""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, Optional, Type, TypeVar

import rosgraph
import rospy

from gpr20_common.errors import ConfigurationError, Gpr20Error, NodeSilentError
from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.high.graph_keeper import GraphKeeper
from gpr20_common.low.links import NodeProbe
from gpr20_common.low.thread_fault import end_with_thread
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_common.mid.node_facts import Hardware, own_software
from gpr20_common.terminal_text import enable_line_buffering, say
from gpr20_msgs.msg import NodeDescription

# A node of the same name that lives answers within this time [s].
ANSWER_LIMIT_S = 1.0
# The topic of what a node says about itself.
DESCRIPTION = "description"
POLL_S = 0.1
# The other nodes of a launch fill a master that came back empty within this time [s].
FILL_LIMIT_S = 10.0

Parameters = TypeVar("Parameters")


def configuration_name() -> str:
    """Return the name of the parameters with which this node was launched; empty if none."""
    return str(rosgraph.names.load_mappings(sys.argv).get("configuration", ""))


def read_parameters(parameter_class: Type[Parameters], section: str) -> Parameters:
    """Return a section of the configuration, or raise an InvalidValueError."""
    name = configuration_name()
    never, deadline_s = threading.Event(), time.monotonic() + FILL_LIMIT_S
    while name and not rospy.has_param(name) and time.monotonic() < deadline_s:
        never.wait(POLL_S)
    text = rospy.get_param(name, "") if name else "{}"
    try:
        sections = json.loads(text)
    except (TypeError, ValueError) as error:
        gone = Message(
            "the configuration of this launch is gone, because the ROS master was restarted; "
            "end the launch and start it again",
            details=f"{name}: {text!r}",
        )
        raise ConfigurationError(gone, fault=OTHER_LAUNCH) from error
    return record_from(parameter_class, sections.get(section, {}), section)


def publish_description(node: str, hardware: Hardware, parameters: Any) -> rospy.Publisher:
    """Publish, latched, what a node below the robot's namespace is; the publisher must be kept."""
    publisher = rospy.Publisher(f"~{DESCRIPTION}", NodeDescription, queue_size=1, latch=True)
    publisher.publish(
        NodeDescription(
            node=node,
            hardware=hardware.name,
            simulated=hardware.simulated,
            time_scale=hardware.time_scale,
            configuration_json=json.dumps(plain(parameters)),
            **dataclasses.asdict(own_software()),
        )
    )
    return publisher


def run_node(name: str, build: Callable[[], Any], needed: bool = True) -> None:
    """Run a node until ROS shuts down; `build` returns what is kept for its life.

    A node whose name is taken by one that lives is not started: ROS would end the other one,
    and of two launches on one master each would end the other's nodes for ever. Its launch ends if
    it is needed: the robot would be incomplete. Else it is started again and again.

    Until the node has started, a signal ends it at once, as the programs in `nodes/` set it.
    """
    enable_line_buffering()
    threading.excepthook = end_with_thread
    configuration = configuration_name()
    launch = roslaunch_number() if needed and configuration else None
    _refuse_second(name, launch)
    try:
        # Its handlers end the node in the main thread, which has locks of rospy while it starts.
        # A robot's time is real, whatever /use_sim_time says: without a /clock all would be 0.
        rospy.init_node(name, disable_rostime=True, disable_signals=True)
    except rospy.ROSInitException as error:
        say(f"{name} was ended before it had started: {error}", file=sys.stderr)
        # At once: rospy's own threads may wait for a master that is gone.
        os._exit(1)
    keeper = GraphKeeper()
    started = f"/gpr20_started{configuration}{rospy.get_name()}"
    try:
        kept = build()
    except Gpr20Error as error:
        rospy.logfatal("%s cannot start: %s", rospy.get_name(), error)
        # One that ran before in this launch, whose hardware is gone, is started again by roslaunch
        # until the hardware is back; the survey waits meanwhile.
        if launch is not None and not rospy.has_param(started):
            rospy.logfatal("%s ends the launch, because it cannot start", rospy.get_name())
            end_with_roslaunch(launch)
        sys.exit(1)
    if configuration:
        rospy.set_param(started, True)
    rospy.loginfo("%s is ready", rospy.get_name())
    rospy.core.register_signals()
    rospy.spin()
    del kept, keeper


def roslaunch_number() -> Optional[int]:
    """Return the process id of the roslaunch that started this process; None if none did."""
    parent = os.getppid()
    try:
        words = Path(f"/proc/{parent}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return None
    is_roslaunch = any(Path(os.fsdecode(word)).name == "roslaunch" for word in words[:2])
    return parent if is_roslaunch else None


def end_with_roslaunch(number: int) -> None:
    """Ask the roslaunch with this process id to end, as Ctrl-C does; wait until it ends this one.

    A process that ended by itself could be started again before roslaunch has reacted. A roslaunch
    that still starts nodes may leave the last of them behind: such a node ends after it.
    """
    os.kill(number, signal.SIGINT)
    never = threading.Event()
    while os.getppid() == number:
        never.wait(POLL_S)


def _refuse_second(default: str, launch: Optional[int]) -> None:
    given = rosgraph.names.load_mappings(sys.argv).get("__name", default)
    space = rosgraph.names.get_ros_namespace()
    name = str(rosgraph.names.resolve_name(given, f"{space}node"))
    try:
        process = NodeProbe(rosgraph.get_master_uri(), name, name, ANSWER_LIMIT_S).process()
    except NodeSilentError:
        return  # there is none, or it has died and left its name behind
    say(
        f"{name} cannot start: it is already running (process {process}). If this is a second "
        "launch of the robot, end the first one, or give this one its own namespace, such as "
        "ns:=robot2",
        file=sys.stderr,
    )
    if launch is not None:
        say(f"{name} ends the launch, because it cannot start", file=sys.stderr)
        end_with_roslaunch(launch)
    sys.exit(1)
