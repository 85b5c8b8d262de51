"""gpr20 sample: a copy of the sample survey, or of the real line."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import outputs
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.sample.real_line import real_line
from gpr20_analysis.sample.sample_survey import sample_survey
from gpr20_common.catalogue import Catalogue
from gpr20_common.terminal_text import say

MCAP = ".mcap"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("output", type=Path, help="copy to write: .mcap; of the real line .nc")
    parser.add_argument(
        "--real",
        action="store_true",
        help="a line over real ground instead: 14 reinforcing bars in concrete, measured by a GSSI "
        "radar (CHARISMA, CC0)",
    )
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Write the copy and return the exit status."""
    if chosen.real:
        outputs.check([outputs.dataset_output(chosen.output)], [], chosen.overwrite)
        write_dataset(real_line(), chosen.output)
        say(chosen.output)
        return DONE
    if chosen.output.suffix != MCAP:
        raise ExportError(wrong_ending(chosen.output, (MCAP,)))
    outputs.check([Output(chosen.output)], [sample_survey()], chosen.overwrite)
    with atomic_output(chosen.output) as place:
        shutil.copyfile(str(sample_survey()), str(place))
    say(chosen.output)
    return DONE


COMMAND = Command(
    "Write a copy of the sample survey: the traces that the simulated robot recorded over three "
    "buried targets. All data of it are SIMULATED. With --real, a line over real ground.",
    add_arguments,
    run,
)
