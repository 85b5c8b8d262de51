"""gpr20 found: note what was found at a candidate of a survey, or list what was noted."""

from __future__ import annotations

import argparse
import hashlib
import time
from pathlib import Path
from typing import Any, Dict, Optional

from gpr20_analysis import faults
from gpr20_analysis.commands import signing
from gpr20_analysis.commands.annotate_command import refuse_open
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.errors import AnalysisError
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder.annotating import Fact, add_to_survey
from gpr20_survey.folder.found_records import add_found, read_found
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.results.candidate_json import list_from
from gpr20_survey.results.found import LABELS, Found, What, present
from gpr20_survey.trace import utc_time


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("survey", type=Path, help="folder of a survey that has ended")
    add("candidate", nargs="?", help="id of the candidate, such as C03; needs --list")
    add("--list", type=Path, metavar="LIST.json", help="the list of gpr20 candidates with that id")
    add("--at", nargs=2, type=float, metavar=("X_MM", "Y_MM"),
        help="the place, where no candidate is")  # fmt: skip
    add("--what", choices=[one.value for one in What], help="what was found")
    add("--depth-mm", type=float, metavar="MM", help="depth of it, from the surface to its top")
    add("--who", metavar="NAME", help="who found it")
    add("--photo", type=Path, metavar="FILE", help="photograph, which is copied into the survey")
    add("--notes", default="", metavar="TEXT", help="one line, such as the model of the device")
    signing.add_argument(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Add a record if one is given, list what is known and return the exit status."""
    status = DONE
    if chosen.what is not None:
        found = _found(chosen)
        signer = signing.chosen_signer(chosen)
        add = add_found(chosen.survey, found, chosen.photo)

        def change(description: Dict[str, Any]) -> Optional[Fact]:
            refuse_open(chosen.survey, description)
            return add(description)

        add_to_survey(chosen.survey, change, found.time)
        status = signing.sign_again(chosen.survey, signer, catalogue)
    elif chosen.candidate or chosen.at:
        raise AnalysisError(Message("say with --what and --who what was found there, and by whom"))
    records = present(read_found(chosen.survey))
    for one in records:
        row = (
            *(one.candidate or "-", f"{one.x_mm:.0f}", f"{one.y_mm:.0f}"),
            catalogue.text(LABELS[one.what]),
            *("-" if one.depth_mm is None else f"{one.depth_mm:.0f}", one.who, one.time[:16]),
            *(one.photo[:12] or "-", one.notes),
        )
        say("  ".join(row).rstrip())
    if not records:
        say(catalogue.tr("Nothing is noted of what was found in this survey."))
    return status


def _found(chosen: argparse.Namespace) -> Found:
    values: Dict[str, Any] = {
        "what": What(chosen.what),
        "who": chosen.who or "",
        "time": utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US),
        "depth_mm": chosen.depth_mm,
        "notes": chosen.notes,
    }
    if bool(chosen.candidate) == bool(chosen.at) or bool(chosen.candidate) != bool(chosen.list):
        raise AnalysisError(
            Message(
                "give the id of a candidate and with --list its list, because ids depend on how "
                "the image is made; or a place with --at"
            )
        )
    if chosen.at:
        return Found(x_mm=chosen.at[0], y_mm=chosen.at[1], **values)
    content = read_regular(chosen.list)
    survey_id = read_description(chosen.survey)["survey_id"]
    listed = list_from(content.decode("utf-8", "replace"), survey_id)
    one = next((one for one in listed.candidates if one.id == chosen.candidate), None)
    if one is None:
        ids = ", ".join(own.id for own in listed.candidates)
        raise AnalysisError(
            Message(
                "{list} has no {id}; it has {ids}", list=chosen.list, id=chosen.candidate, ids=ids
            ),
            fault=faults.NO_INPUT,
        )
    return Found(
        x_mm=one.x_mm,
        y_mm=one.y_mm,
        candidate=one.id,
        candidate_depth_mm=one.depth_mm,
        list_sha256=hashlib.sha256(content).hexdigest(),
        **values,
    )


COMMAND = Command(
    "Note in a survey what was found at a candidate: nothing, scrap or a device. A later record of "
    "the same candidate replaces an earlier one, which stays in its log. Without --what, list it.",
    add_arguments,
    run,
)
