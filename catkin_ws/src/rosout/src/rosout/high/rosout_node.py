"""Collects what all nodes say: `/rosout` goes to a file and, together, to `/rosout_agg`."""

from __future__ import annotations

from pathlib import Path

import rospkg
import rospy
from rosgraph_msgs.msg import Log

from gpr20_common.high.node import run_node
from rosout.low.log_file import LogFile
from rosout.mid.log_entry import LogEntry

QUEUE_SIZE = 1000


class RosoutNode:
    """Subscribes `/rosout`; roslaunch and roscore start it with every master."""

    def __init__(self, file: LogFile) -> None:
        self._file = file
        self._together = rospy.Publisher("/rosout_agg", Log, queue_size=QUEUE_SIZE)
        self._subscriber = rospy.Subscriber("/rosout", Log, self._hear, queue_size=QUEUE_SIZE)
        rospy.on_shutdown(file.close)

    def _hear(self, message: Log) -> None:
        place = f"{message.file}:{message.line}({message.function})"
        self._file.write(
            LogEntry(
                message.header.stamp.to_sec(), message.level, message.name, place, message.msg
            ).line()
        )
        self._together.publish(message)


def log_path() -> Path:
    """Return where roslaunch keeps the logs of this run."""
    return Path(rospkg.get_log_dir()) / rospy.get_param("/run_id", "") / "rosout.log"


def main() -> None:
    """Run the node."""
    run_node("rosout", lambda: RosoutNode(LogFile(log_path())))
