"""Whether the modules of others are there that the nodes import.

It is asked before anything imports them, so it imports nothing but the standard library.
"""

from __future__ import annotations

import importlib.util
import platform
import sys
from typing import Iterable

NEEDED = (
    *("actionlib", "actionlib_msgs", "diagnostic_msgs", "diagnostic_updater", "genpy"),
    *("geometry_msgs", "rosgraph", "rosgraph_msgs", "roslib", "rospy", "sensor_msgs", "std_msgs"),
    *("tf2_msgs", "visualization_msgs", "numpy", "rospkg", "yaml", "lz4", "mcap", "polib"),
    *("pydantic", "rosbags", "vxi11", "zstandard"),
)


def what_to_install(needed: Iterable[str] = NEEDED) -> str:
    """Return what is missing and how it is installed; empty if nothing is."""
    missing = ", ".join(one for one in needed if importlib.util.find_spec(one) is None)
    return missing and (
        f"{sys.executable} (Python {platform.python_version()}) lacks the modules {missing}.\n"
        "In a checkout run: scripts/setup.sh\n"
        "In an install space install what docs/install_space.md lists. Where packages are\n"
        "installed, install them again, as docs/maintain.md describes."
    )
