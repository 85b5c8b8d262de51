"""Where the processes of one simulated robot find their common truth."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import rospy

SHARED_MEMORY = Path("/dev/shm")


def world_path(robot_namespace: str) -> Path:
    """Return the file of the simulated world of one robot under this ROS master.

    Every process of the robot finds the same file without asking another one, a
    restarted process finds it again, and the next launch gets a fresh world.

    Args:
        robot_namespace: Namespace in which the robot was launched, "/" or "/robot1".
    """
    run_id = str(rospy.get_param("/run_id"))
    name = hashlib.sha256(f"{run_id} {robot_namespace.rstrip('/')}".encode()).hexdigest()[:32]
    # A folder for each user: nobody can be kept out, or let in, by another one.
    return SHARED_MEMORY / f"gpr20-{os.getuid()}" / name
