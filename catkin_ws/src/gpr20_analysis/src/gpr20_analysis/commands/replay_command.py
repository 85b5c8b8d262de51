"""gpr20 replay: publish a survey on its ROS topics."""

from __future__ import annotations

import argparse
import threading
from pathlib import Path

from gpr20_analysis.commands.command import DONE, REFUSED, Command
from gpr20_analysis.errors import AnalysisError, MissingLibraryError, not_there
from gpr20_analysis.read.replay import Pace, paced, recorded
from gpr20_common.catalogue import Catalogue
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message

SUBSCRIBER_WAIT_S = 2.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("survey", type=Path, help="folder of a survey, its .mcap, or JSON files")
    parser.add_argument("--rate", type=float, default=1.0, help="speed relative to the recording")
    parser.add_argument(
        "--longest-pause",
        type=float,
        metavar="S",
        help="shorten longer pauses of the recording, such as a night, to this [s]",
    )


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Publish the survey; return the exit status."""
    pace = Pace(chosen.rate, chosen.longest_pause)
    if not chosen.survey.exists():
        raise AnalysisError(not_there(chosen.survey))
    try:
        import rosgraph
        import rospy

        from gpr20_analysis.high.replay_node import ReplayNode
    except ImportError as error:
        raise MissingLibraryError(
            Message("a replay needs ROS; source catkin_ws/devel/setup.bash first", details=error)
        ) from error
    if not rosgraph.is_master_online():
        raise AnalysisError(
            Message(
                "no ROS master answers at {address}; start roscore, or use roslaunch gpr20 "
                "replay.launch",
                address=rosgraph.get_master_uri(),
            )
        )
    rospy.init_node("replay", anonymous=False)
    stopped = threading.Event()
    node = ReplayNode(stopped, SUBSCRIBER_WAIT_S)
    node.run(paced(recorded(chosen.survey), pace, Clock(), stopped))
    print(
        catalogue.tr(
            "{traces} traces in {messages} messages were published",
            traces=node.traces,
            messages=node.published,
        )
    )
    return REFUSED if stopped.is_set() else DONE


COMMAND = Command(
    "Publish a recorded survey on its ROS topics. Needs ROS and a master. Bags: use rosbag play.",
    add_arguments,
    run,
)
