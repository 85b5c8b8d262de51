"""gpr20 info: what a survey contains and what is missing in it."""

from __future__ import annotations

import argparse
import json

from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import Command, print_rows
from gpr20_analysis.report.summary import summarize, summary_of, warnings_of
from gpr20_analysis.sentences import LIST_ATTRIBUTES, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    parser.add_argument(
        "--json", action="store_true", help="print everything as JSON, for programs"
    )


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Print what the survey contains and return the exit status."""
    survey = inputs.load(chosen, catalogue)
    if chosen.json:
        lists = {name: survey.attrs.get(name, []) for name in LIST_ATTRIBUTES}
        lists["warnings"] = [str(one) for one in warnings_of(survey)]
        print(json.dumps({**summarize(survey), **lists}, indent=2))
    else:
        print_rows(summary_of(survey), catalogue)
        for one in warnings_of(survey):
            say(shown(one, catalogue))
    return inputs.status_of(survey)


COMMAND = Command(
    "Show what a survey contains, and what is missing or damaged in it.", add_arguments, run
)
