"""gpr20 markers: the places of a survey that people noted."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gpr20_analysis.candidates.files import output_paths
from gpr20_analysis.candidates.marker_files import check_markers_path, json_text, write_markers
from gpr20_analysis.candidates.marker_list import marker_lines, survey_markers
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_common.catalogue import Catalogue
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, action="append", default=[],
        help="markers as .csv, .json or .geojson; may be given more than once")  # fmt: skip
    outputs.add_overwrite(parser)
    add("--removed", action="store_true", help="list markers that were removed too")
    add("--json", action="store_true", help="print the markers as JSON, for programs")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Print and write the markers; return the exit status."""
    for path in chosen.output:
        check_markers_path(path)
    written = [Output(one) for path in chosen.output for one in output_paths(path)]
    outputs.check(written, [chosen.survey], chosen.overwrite)
    survey = inputs.load(chosen, catalogue)
    found = survey_markers(survey, chosen.removed)
    for path in chosen.output:
        write_markers(found, path)
    if chosen.json:
        print(json.dumps(json.loads(json_text(found)), indent=2))
    else:
        for line in marker_lines(found, catalogue):
            say(line)
    return inputs.status_of(survey)


COMMAND = Command(
    "List the markers that people set in a survey on the robot's window.", add_arguments, run
)
