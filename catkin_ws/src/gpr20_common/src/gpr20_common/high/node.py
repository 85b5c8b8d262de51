"""The life of a node: start, say clearly what is wrong, run, end."""

from __future__ import annotations

import sys
from typing import Any, Callable

import rospy

from gpr20_common.errors import Gpr20Error


def run_node(name: str, build: Callable[[], Any]) -> None:
    """Run a node until ROS shuts down.

    Args:
        name: Default name of the node.
        build: Reads the parameters, builds the objects and connects them. What it
            returns is kept for the life of the node.
    """
    rospy.init_node(name)
    try:
        kept = build()
    except Gpr20Error as error:
        rospy.logfatal("%s cannot start: %s", rospy.get_name(), error)
        sys.exit(1)
    rospy.loginfo("%s is ready", rospy.get_name())
    rospy.spin()
    del kept
