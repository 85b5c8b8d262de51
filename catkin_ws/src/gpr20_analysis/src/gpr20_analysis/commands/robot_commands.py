"""gpr20 replay and doctor, which need ROS and the workspace."""

from __future__ import annotations

import argparse
import contextlib
import re
import sys
from pathlib import Path
from typing import Iterator

from gpr20_analysis import errors
from gpr20_analysis.commands.command import DONE, REFUSED, Command
from gpr20_analysis.errors import MissingLibraryError
from gpr20_common.catalogue import Catalogue
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


@contextlib.contextmanager
def _needing_ros() -> Iterator[None]:
    try:
        yield
    except ImportError as error:
        # Installed with pip, without the workspace.
        raise MissingLibraryError(
            Message(
                "this command needs ROS; source catkin_ws/devel/setup.bash first", details=error
            ),
            fault=errors.NO_ROS,
        ) from error


def _add_replay(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("survey", type=Path, help="folder of a survey, or its recording")
    add("--ns", default="replay", metavar="NAME", type=_namespace,
        help="namespace in which it is published; default: replay")  # fmt: skip
    add("--rate", type=float, default=1.0, help="speed relative to the recording")
    add("--paused", action="store_true", help="start paused")
    add("--hold", action="store_true", help="keep the last messages until interrupted")
    add("--wait", type=float, default=0.0, metavar="S",
        help="wait at most this long for a window before the first message [s]")  # fmt: skip


def _replay(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    from gpr20_analysis.read.replay import Playback, describe, recorded

    playback = Playback(Clock(), chosen.rate, chosen.paused)
    replayed = describe(chosen.survey)
    with _needing_ros():
        import rospy

        from gpr20_analysis import replay_node
    replay_node.refuse_beside_others(f"{chosen.ns}{name}" for name in replay_node.TOPICS_OF_A_ROBOT)
    # Two replays in different namespaces do not end each other.
    rospy.init_node("replay", anonymous=True)
    rospy.on_shutdown(playback.stop)
    node = replay_node.ReplayNode(playback, replayed, chosen.ns)
    node.run(recorded(chosen.survey), chosen.wait)
    stopped = playback.stopped
    say(f"{node.traces} traces were published")
    if chosen.hold:
        sys.stdout.flush()
        rospy.spin()
    return REFUSED if stopped else DONE


def _namespace(name: str) -> str:
    """Return an absolute namespace with a slash at its end."""
    own = name.strip("/")
    if own and not re.fullmatch(r"[A-Za-z]\w*(/[A-Za-z]\w*)*", own, re.ASCII):
        raise argparse.ArgumentTypeError(f"{name} is no namespace of ROS, such as replay")
    return f"/{own}/" if own else "/"


def _add_doctor(parser: argparse.ArgumentParser) -> None:
    with _needing_ros():
        from gpr20_doctor import add_arguments
    add_arguments(parser)


def _doctor(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    with _needing_ros():
        from gpr20_doctor.high import doctor
    return doctor.run(chosen, catalogue)


REPLAY = Command(
    "Publish a recorded survey on ROS topics. Needs ROS and a master.", _add_replay, _replay
)
DOCTOR = Command(
    "Find what is wrong with the robot and this computer. Needs ROS and the workspace.",
    _add_doctor,
    _doctor,
    "exit status: 0 nothing is wrong, 1 a warning or something unknown, 2 a fault, 3 the doctor "
    "itself could not work",
)
