"""gpr20 verify: check a survey's folder, and repair its log and manifest if asked to."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.failure import first_steps
from gpr20_analysis.read.repair import repair_survey
from gpr20_analysis.read.signature import look_at_signature
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.sentences import DOUBTS, NOTES, json_fields, labelled, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say

LISTED = 50
"""Number of faults that are printed without --all."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("folder", type=Path, help="folder of one survey")
    add("--all", action="store_true", help=f"print all faults, not only the first {LISTED}")
    add("--signers", type=Path, metavar="FILE",
        help="require a signature by a key of this file (allowed_signers of OpenSSH)",
        )  # fmt: skip
    add("--repair", action="store_true",
        help="write manifest.json or a file of the log of a closed survey again if it is missing "
        "or damaged and all else agrees; what nothing vouches for is named for ever, and gpr20 "
        "sign signs the new manifest")  # fmt: skip
    add("--json", action="store_true", help="print everything as JSON, for programs")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Check the folder, print what was found and return the exit status."""
    progress = inputs.progress_bar("verifying")
    folder = chosen.folder.expanduser()
    repaired = repair_survey(folder, progress) if chosen.repair else []
    signed = look_at_signature(folder, chosen.signers)
    found = verify_survey(folder, progress)
    status = max(found.status, signed.status)
    if chosen.json:
        record = {**found.record(), "status": status, "signature": signed.record()}
        record["repair"] = [json_fields(one) for one in repaired]
        print(json.dumps(record, indent=2))
        return status
    listed = found.faults if chosen.all else found.faults[:LISTED]
    lines = [Message("FAULT: {sentence}", sentence=fault) for fault in listed]
    others = len(found.faults) - len(listed)
    if others:
        lines.append(Message("... and {count} more; --all prints all of them", count=others))
    notes = [*repaired, *found.notes, *([] if signed.state else [signed.message])]
    for name, sentences in ((DOUBTS, found.doubts), (NOTES, notes)):
        lines += [labelled(name, one) for one in sentences]
    lines += [found.verdict, *first_steps(found.verdict)]
    # Last, so that "complete" is never the last word on what nobody vouches for.
    if signed.state:
        lines += [signed.message, *first_steps(signed.message)]
    for line in lines:
        say(shown(line, catalogue))
    return status


COMMAND = Command(
    "Check a survey's folder: files, values, positions, signature. Without --repair nothing is "
    "changed; with it traces and recordings are not.",
    add_arguments,
    run,
)
