"""Which modules of others the nodes import, and what to install where one is missing.

It is asked before anything imports them, so it imports nothing but the standard library.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import sys
from typing import Callable, Iterable, List, Optional

# Of ROS: a package of the system, whose name follows from that of the module.
FROM_ROS = (
    *("actionlib", "actionlib_msgs", "diagnostic_msgs", "diagnostic_updater", "genpy"),
    *("geometry_msgs", "rosgraph", "rosgraph_msgs", "roslib", "rospy", "sensor_msgs", "std_msgs"),
    *("tf2_msgs", "visualization_msgs"),
)
FROM_SYSTEM = {"numpy": "python3-numpy", "rospkg": "python3-rospkg", "yaml": "python3-yaml"}
FROM_PIP = {
    **{name: name for name in ("lz4", "mcap", "polib", "pydantic", "rosbags")},
    "vxi11": "python-vxi11",
    "zstandard": "zstandard",
}
NOETIC = "/opt/ros/noetic"


def is_there(module: str) -> bool:
    """Return whether this interpreter finds a module; it is not imported."""
    return importlib.util.find_spec(module) is not None


def what_to_install(there: Callable[[str], bool] = is_there) -> Optional[str]:
    """Return what is missing and the commands that install it; None if nothing is."""
    ros = _absent(FROM_ROS, there)
    system = _absent(FROM_SYSTEM, there)
    pip = _absent(FROM_PIP, there)
    if not ros + system + pip:
        return None
    lines = [
        f"{sys.executable} (Python {platform.python_version()}) lacks the modules "
        f"{', '.join(ros + system + pip)}."
    ]
    packages = [_ros_package(one) for one in ros] + [FROM_SYSTEM[one] for one in system]
    if packages:
        lines.append(f"Install packages of the system: sudo apt-get install {' '.join(packages)}")
    if pip:
        names = " ".join(FROM_PIP[one] for one in pip)
        lines.append(
            f"Install Python packages into its virtual environment: python3 -m pip install {names}"
        )
    lines.append("docs/install_space.md lists what an install space needs.")
    return "\n".join(lines)


def _absent(modules: Iterable[str], there: Callable[[str], bool]) -> List[str]:
    return [one for one in modules if not there(one)]


def _ros_package(module: str) -> str:
    noetic = NOETIC in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    prefix = "ros-noetic-" if noetic else "python3-"
    return prefix + module.replace("_", "-")
