"""gpr20 replay: publish a survey on its ROS topics."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DONE, REFUSED, Command
from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_analysis.read.replay import Playback, describe, recorded
from gpr20_common.catalogue import Catalogue
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("survey", type=Path, help="folder of a survey, or its recording")
    add("--ns", default="replay", metavar="NAME",
        help="namespace in which it is published; default: replay")  # fmt: skip
    add("--rate", type=float, default=1.0, help="speed relative to the recording")
    add("--start", type=float, default=0.0, metavar="S",
        help="start at this time of the recording [s]; earlier traces are published at once",
        )  # fmt: skip
    add("--paused", action="store_true", help="start paused")
    add("--hold", action="store_true", help="keep the last messages until interrupted")
    add("--wait", type=float, default=0.0, metavar="S",
        help="wait at most this long for a window before the first message [s]")  # fmt: skip


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Publish the survey; return the exit status."""
    playback = Playback(Clock(), chosen.rate, chosen.start, chosen.paused)
    namespace = _namespace(chosen.ns)
    replayed = describe(chosen.survey)
    try:
        import rosgraph
        import rospy

        from gpr20_analysis.high import replay_node
    except ImportError as error:
        raise MissingLibraryError(
            Message("a replay needs ROS; source catkin_ws/devel/setup.bash first", details=error),
            fault=faults.NO_ROS,
        ) from error
    if not rosgraph.is_master_online():
        raise AnalysisError(
            Message(
                "no ROS master answers at {address}; start roscore, or use roslaunch gpr20 "
                "replay.launch",
                address=rosgraph.get_master_uri(),
            ),
            fault=faults.NO_ROS,
        )
    replay_node.refuse_beside_others(f"{namespace}{name}" for name in replay_node.TOPICS_OF_A_ROBOT)
    # Two replays in different namespaces do not end each other.
    rospy.init_node("replay", anonymous=True)
    rospy.on_shutdown(playback.stop)
    node = replay_node.ReplayNode(playback, replayed, namespace, chosen.wait)
    node.run(recorded(chosen.survey))
    stopped = playback.stopped
    say(f"{node.traces} traces in {node.published} messages were published")
    if chosen.hold:
        sys.stdout.flush()
        rospy.spin()
    return REFUSED if stopped else DONE


def _namespace(name: str) -> str:
    """Return an absolute namespace with a slash at its end."""
    own = name.strip("/")
    if own and not re.fullmatch(r"[A-Za-z]\w*(/[A-Za-z]\w*)*", own, re.ASCII):
        raise AnalysisError(
            Message(
                "{name} is no namespace of ROS; use letters, digits and _, such as replay",
                name=name,
            )
        )
    return f"/{own}/" if own else "/"


COMMAND = Command(
    "Publish a recorded survey on ROS topics. Needs ROS and a master.", add_arguments, run
)
