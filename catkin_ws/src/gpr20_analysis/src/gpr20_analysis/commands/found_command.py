"""gpr20 found: note what was found at a candidate of a survey, or list what was noted."""

from __future__ import annotations

import argparse
import hashlib
import time
from pathlib import Path
from typing import Any, Dict

from gpr20_analysis import faults
from gpr20_analysis.commands.annotate_command import refuse_open
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.checks import found_in
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import Fact, add_to_survey, read_description, recover
from gpr20_survey.results.candidates import list_from
from gpr20_survey.results.found import PHOTOS, Found, What, present
from gpr20_survey.trace import utc_time


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("survey", type=Path, help="folder of a survey that has ended")
    add("candidate", nargs="?", help="id of the candidate, such as C03")
    add("--list", type=Path, metavar="LIST.json", help="the list of gpr20 candidates with that id")
    add("--what", choices=[one.value for one in What], help="what was found")
    add("--depth-mm", type=float, metavar="MM", help="depth of it, from the surface to its top")
    add("--who", metavar="NAME", default="", help="who found it")
    add("--photo", type=Path, metavar="FILE", help="photograph, which is copied into the survey")
    add("--notes", default="", metavar="TEXT", help="one line, such as the model of the device")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Add a record if one is given, list what is known and return the exit status."""
    given = [one is not None for one in (chosen.candidate, chosen.list, chosen.what)]
    if any(given) and not all(given):
        raise AnalysisError(Message("give a candidate, --list and --what, or none of them"))
    if all(given):
        _add(chosen)
    for one in present(found_in(recover(chosen.survey).found.records)):
        depth = "-" if one.depth_mm is None else f"{one.depth_mm:.0f}"
        place = (one.candidate, f"{one.x_mm:.0f}", f"{one.y_mm:.0f}", one.what.value, depth)
        say("  ".join([*place, one.who, one.time[:16], one.notes]).rstrip())
    return DONE


def _add(chosen: argparse.Namespace) -> None:
    now = utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)
    photo = None if chosen.photo is None else read_regular(chosen.photo)
    own = hashlib.sha256(photo or b"").hexdigest()
    name = "" if photo is None else own + chosen.photo.suffix.lower()
    given = {"who": chosen.who, "notes": chosen.notes, "depth_mm": chosen.depth_mm, "photo": name}
    found = Found(What(chosen.what), **_candidate(chosen), **given, time=now)

    def change(description: Dict[str, Any]) -> Fact:
        refuse_open(chosen.survey, description)
        if photo is not None:  # durable before the record that names it
            folder = chosen.survey / PHOTOS
            durable_files.ensure_folder(folder)
            durable_files.write_new_file(folder / name, photo)
        return Fact(Kind.FOUND, found.values())

    add_to_survey(chosen.survey, change, now)


def _candidate(chosen: argparse.Namespace) -> Dict[str, Any]:
    """Return id and place of the candidate, and its list: ids depend on how an image is made."""
    content = read_regular(chosen.list)
    survey_id = read_description(chosen.survey)["survey_id"]
    listed = list_from(content.decode("utf-8", "replace"), survey_id).candidates
    for one in listed:
        if one.id == chosen.candidate:
            own = hashlib.sha256(content).hexdigest()
            return {"x_mm": one.x_mm, "y_mm": one.y_mm, "candidate": one.id, "list_sha256": own}
    ids = ", ".join(one.id for one in listed)
    other = Message("there is no candidate {id}; write {ids}", id=chosen.candidate, ids=ids)
    raise AnalysisError(other, fault=faults.INPUT)


COMMAND = Command(
    "Note in a survey what was found at a candidate: nothing, scrap or a device. A later record of "
    "the same candidate replaces an earlier one, which stays in its log. Without --what, list it.",
    add_arguments,
    run,
)
