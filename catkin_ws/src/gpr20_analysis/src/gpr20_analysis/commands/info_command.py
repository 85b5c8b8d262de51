"""gpr20 info: what a survey holds and what is missing in it."""

from __future__ import annotations

import argparse
import json

from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.report.summary import summarize


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    parser.add_argument("--json", action="store_true", help="for programs: everything, as JSON")


def run(chosen: argparse.Namespace) -> int:
    """Tell what the survey holds and return the exit status."""
    survey = inputs.load(chosen)
    told = summarize(survey)
    if chosen.json:
        lists = {key: survey.attrs.get(key, []) for key in ("missing", "faults", "notes")}
        print(json.dumps({**told, **lists}, indent=2))
    else:
        for title, text in told.items():
            print(f"{title + ':':20}{text}")
    return inputs.status_of(survey)


COMMAND = Command(
    "Tell what a survey holds, and name what is missing or damaged in it.", add_arguments, run
)
