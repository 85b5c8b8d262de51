"""gpr20 candidates: the places in the ground that an operator should look at."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from gpr20_analysis import faults
from gpr20_analysis.candidates.files import (
    check_candidates_path,
    output_paths,
    write_candidates,
)
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.commands import image_command, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import BASE_LINK
from gpr20_survey.results.candidates import CandidateList, json_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    image_command.add_image_options(parser)
    image_command.add_candidate_options(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, action="append", default=[],
        help="list as .csv, .json, .geojson or .gpkg; may be given more than once")  # fmt: skip
    outputs.add_overwrite(parser)
    add("--json", action="store_true", help="print the candidates as JSON, for programs")
    add("--publish", action="store_true",
        help="publish the list and markers on ROS topics until interrupted; needs ROS and a "
        "master")  # fmt: skip


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Find, print and write the candidates; return the exit status."""
    options = image_command.options_of(chosen)
    listed = image_command.candidate_options_of(chosen)
    steps = image_command.steps_of(chosen)
    for path in chosen.output:
        check_candidates_path(path)
    written = [Output(one) for path in chosen.output for one in output_paths(path)]
    outputs.check(written, inputs.inputs_of(chosen, steps), chosen.overwrite)
    if chosen.publish:
        _require_master()
    image, status = image_command.image_of(chosen, options, catalogue)
    found = find_candidates(image, listed, image_command.clean_ground_of(chosen))
    for path in chosen.output:
        write_candidates(found, path)
    if chosen.json:
        print(json.dumps(json.loads(json_text(found)), indent=2))
    else:
        image_command.print_candidates(image, found, chosen, catalogue)
    if chosen.publish:
        sys.stdout.flush()
        _publish(found)
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
    "noise. It is a list, no clearance. Without steps the mean of all traces is subtracted first.",
    add_arguments,
    run,
)
