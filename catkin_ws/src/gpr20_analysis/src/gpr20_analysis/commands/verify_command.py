"""gpr20 verify: check a survey's folder; gpr20-verify is the same."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import printable

FAULTS_TOLD = 50


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("folder", type=Path, help="folder of one survey")
    parser.add_argument("--all", action="store_true", help=f"tell more than {FAULTS_TOLD} faults")


def run(chosen: argparse.Namespace) -> int:
    """Check the folder, tell what was found and return the exit status."""
    found = verify_survey(chosen.folder, inputs.progress_bar("verifying"))
    told = found.faults if chosen.all else found.faults[:FAULTS_TOLD]
    for fault in told:
        print(f"FAULT: {printable(fault)}")
    if len(told) < len(found.faults):
        print(f"... and {len(found.faults) - len(told)} more; --all tells them")
    for note in found.notes:
        print(f"note: {note}")
    print(found.verdict)
    return found.status


COMMAND = Command(
    "Check a survey's folder: files, numbers, places. Nothing is changed.", add_arguments, run
)
