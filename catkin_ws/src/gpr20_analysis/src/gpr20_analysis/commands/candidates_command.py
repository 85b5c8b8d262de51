"""gpr20 candidates: the places in the ground that an operator should look at."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from gpr20_analysis import faults
from gpr20_analysis.candidates.files import check_ending, output_paths, write_candidates
from gpr20_analysis.commands import image_options, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import BASE_LINK
from gpr20_survey.results.candidates import CandidateList


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    image_options.add_options(parser)
    image_options.add_list_options(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, action="append", default=[],
        help="list as .csv, .json or .geojson, with all weaker echoes; may be given more than "
        "once")  # fmt: skip
    outputs.add_overwrite(parser)
    add("--publish", action="store_true",
        help="publish the list and markers on ROS topics until interrupted; needs ROS and a "
        "master")  # fmt: skip


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Find, print and write the candidates; return the exit status."""
    options = image_options.options_of(chosen)
    steps = image_options.steps_of(chosen)
    for path in chosen.output:
        check_ending(path)
    written = [Output(one) for path in chosen.output for one in output_paths(path)]
    outputs.check(written, inputs.inputs_of(chosen, steps), chosen.overwrite)
    if chosen.publish:
        _require_master()
    found, status = image_options.answer_of(chosen, options, catalogue)
    for path in chosen.output:
        write_candidates(found.found, path)
    image_options.print_answer(found, chosen, catalogue)
    if chosen.publish:
        sys.stdout.flush()
        _publish(found.found)
    return status


def _require_master() -> None:
    try:
        import rosgraph

        import gpr20_analysis.high.candidate_topics  # noqa: F401
    except ImportError as error:
        raise MissingLibraryError(
            Message("--publish needs ROS; source catkin_ws/devel/setup.bash first", details=error),
            fault=faults.NO_ROS,
        ) from error
    if not rosgraph.is_master_online():
        raise AnalysisError(
            Message(
                "no ROS master answers at {address}; start roscore",
                address=rosgraph.get_master_uri(),
            ),
            fault=faults.NO_ROS,
        )


def _publish(found: CandidateList) -> None:
    import rospy

    from gpr20_analysis.high.candidate_topics import CandidateTopics

    # A robot beside it records the markers; without a /clock their time would be 0.
    rospy.init_node("candidates", anonymous=True, disable_rostime=True)
    CandidateTopics(BASE_LINK).publish(found)
    rospy.spin()


COMMAND = Command(
    "List the candidates in the ground below a survey: places where its image is brighter than "
    "clutter. It is a list, no clearance. Without steps coupling and surface echo are subtracted.",
    add_arguments,
    run,
)
