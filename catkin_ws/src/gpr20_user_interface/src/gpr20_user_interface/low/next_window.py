"""Another window in place of this process."""

from __future__ import annotations

import os
import sys
from typing import Dict, List, Mapping, NoReturn, Sequence

# roslaunch gives a name; in another namespace it could be that of a window that is open there.
OWN_NAMES = ("__ns:=", "__name:=")
NAMESPACE = "ROS_NAMESPACE"


def open_in(namespace: str, words: Sequence[str], environment: Mapping[str, str]) -> NoReturn:
    """Run this program for another robot in this process, with the same options.

    The process stays the one that roslaunch started: it ends with its launch.

    Args:
        namespace: Namespace of the robot.
        words: Program and options of this process, as in `sys.argv`.
        environment: Environment of this process.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os.execve(sys.executable, command(namespace, words), with_namespace(namespace, environment))


def command(namespace: str, words: Sequence[str]) -> List[str]:
    """Return the command of the window of another robot."""
    kept = [word for word in words if not word.startswith(OWN_NAMES)]
    return [sys.executable, *kept, f"__ns:={namespace}"]


def with_namespace(namespace: str, environment: Mapping[str, str]) -> Dict[str, str]:
    """Return the environment of the window of another robot."""
    return {**environment, NAMESPACE: namespace}
