"""gpr20 repair: write a lost or damaged manifest, or a file of the log, again."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import List

from gpr20_analysis import __version__
from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import DAMAGED, Command
from gpr20_analysis.read.manifest_repair import Repair, repair_manifest
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.trace import utc_time


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("folder", type=Path, help="folder of one survey that was closed")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Repair the log and the manifest, print what was done and return the exit status."""
    folder = chosen.folder.expanduser()
    now = utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)
    progress = inputs.progress_bar("verifying")
    result = repair_manifest(folder, f"gpr20 {__version__}", now, progress)
    lines = [Message("FAULT: {sentence}", sentence=fault) for fault in result.faults]
    lines += [Message("note: {sentence}", sentence=note) for note in result.notes]
    if result.repair is Repair.IMPOSSIBLE:
        lines.append(
            Message(
                "nothing was changed: more than the log and the manifest is damaged; resume the "
                "survey, which repairs its files"
            )
        )
        _print(lines, catalogue)
        return DAMAGED
    if result.repair is Repair.NOT_NEEDED:
        lines.append(Message("nothing was changed: every file is as in the manifest"))
    found = verify_survey(folder, progress)
    _print([*lines, found.verdict], catalogue)
    return found.status


def _print(lines: List[Message], catalogue: Catalogue) -> None:
    for line in lines:
        say(shown(line, catalogue))


COMMAND = Command(
    "Write manifest.json or a file of the log of a closed survey again if it is missing or damaged "
    "and all else agrees. Traces and recordings are not changed; what nothing vouches for is named "
    "for ever. A signature does not fit a new manifest: gpr20 sign makes another.",
    add_arguments,
    run,
)
