"""gpr20 info: what a survey holds and what is missing in it."""

from __future__ import annotations

import argparse
import json

from gpr20_analysis.commands import survey_input
from gpr20_analysis.commands.command import Command
from gpr20_analysis.mid.survey_facts import facts


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    survey_input.add_survey(parser)
    parser.add_argument("--json", action="store_true", help="for programs: everything, as JSON")


def run(chosen: argparse.Namespace) -> int:
    """Tell what the survey holds and return the exit status."""
    survey = survey_input.load(chosen)
    told = facts(survey)
    if chosen.json:
        lists = {key: survey.attrs.get(key, []) for key in ("missing", "faults", "notes")}
        print(json.dumps({**told, **lists}, indent=2))
    else:
        for title, text in told.items():
            print(f"{title + ':':20}{text}")
    return survey_input.status_of(survey)


COMMAND = Command(
    "Tell what a survey holds, and name what is missing or damaged in it.", add_arguments, run
)
