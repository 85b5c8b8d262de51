"""gpr20 replay: a survey back onto the ROS topics."""

from __future__ import annotations

import argparse
import threading
from pathlib import Path

from gpr20_analysis.commands.command import DONE, REFUSED, Command
from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_analysis.read.replay import Pace, paced, recorded
from gpr20_common.low.clock import Clock

SUBSCRIBER_WAIT_S = 2.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("survey", type=Path, help="folder of a survey, its .mcap, or JSON files")
    parser.add_argument("--rate", type=float, default=1.0, help="how many times faster than it was")
    parser.add_argument(
        "--longest-pause",
        type=float,
        metavar="S",
        help="shorten pauses of the recording, as of a survey that waited overnight, to this [s]",
    )


def run(chosen: argparse.Namespace) -> int:
    """Publish the survey; return the exit status."""
    pace = Pace(chosen.rate, chosen.longest_pause)
    if not chosen.survey.exists():
        raise AnalysisError(f"{chosen.survey} does not exist")
    try:
        import rosgraph
        import rospy

        from gpr20_analysis.high.replay_node import ReplayNode
    except ImportError as error:
        raise MissingLibraryError(
            f"replay needs ROS ({error}): source catkin_ws/devel/setup.bash first"
        ) from error
    if not rosgraph.is_master_online():
        raise AnalysisError(
            f"no ROS master answers at {rosgraph.get_master_uri()}; start roscore, or use "
            "roslaunch gpr20 replay.launch"
        )
    rospy.init_node("replay", anonymous=False)
    stopped = threading.Event()
    node = ReplayNode(stopped, SUBSCRIBER_WAIT_S)
    node.run(paced(recorded(chosen.survey), pace, Clock(), stopped))
    print(f"{node.traces} traces in {node.published} messages were published")
    return REFUSED if stopped.is_set() else DONE


COMMAND = Command(
    "Publish a recorded survey on its ROS topics. Needs ROS and a master. Bags: rosbag play.",
    add_arguments,
    run,
)
