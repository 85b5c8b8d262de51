"""gpr20 annotate: what people add to a survey: its name and place, markers, and what was found."""

from __future__ import annotations

import argparse
import hashlib
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, Optional

from gpr20_analysis import errors
from gpr20_analysis.candidates.files import ENDINGS, output_paths
from gpr20_analysis.candidates.table import marker_lines, marker_list, write_markers
from gpr20_analysis.commands import arguments
from gpr20_analysis.commands.command import DONE, Command, number, print_rows
from gpr20_analysis.errors import AnalysisError, check_ending, not_there
from gpr20_analysis.read.checks import found_rows
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import IN_USE
from gpr20_common.message import Message, verbatim
from gpr20_common.terminal_text import say
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import read_regular
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import Fact, add_to_survey, read_description
from gpr20_survey.plan.annotation import (
    Annotation,
    Wgs84Position,
    annotation_of,
    position_from_text,
)
from gpr20_survey.plan.markers import PHOTO_ENDINGS, PHOTOS, Found, What
from gpr20_survey.results.candidates import AreaPosition, list_from
from gpr20_survey.trace import utc_time

NAMES = ("name", "operator", "site", "notes", "position", "heading_deg")
"""Those of the options, and of the fields of an Annotation."""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    unset = argparse.SUPPRESS
    add("survey", type=Path, help="folder of a survey that has ended")
    add("--name", default=unset, help="what the survey is called; its folder stays as it is")
    add("--operator", default=unset, metavar="NAME", help="who measured")
    add("--site", default=unset, metavar="NAME", help="where, in words")
    add("--notes", default=unset, metavar="TEXT", help="the rest; may have several lines")
    add("--position", default=unset, metavar="LAT,LON", type=_position,
        help="where: WGS 84 latitude and longitude in degrees, north and east positive; with a "
        "negative latitude write --position=LAT,LON; '' removes it")  # fmt: skip
    add("--heading", default=unset, dest="heading_deg", metavar="DEG", type=_heading,
        help="direction of +Y, clockwise from true north, 0 to 360; +X is 90 degrees to its "
        "right; '' removes it")  # fmt: skip
    add("--found", metavar="ID", help="note what was found at a candidate, such as C03")
    add("--list", type=Path, metavar="LIST.json", help="the list of gpr20 candidates with that id")
    add("--what", choices=[one.value for one in What], help="what was found")
    add("--depth-mm", type=float, metavar="MM", help="depth of it, from the surface to its top")
    add("--who", metavar="NAME", default="", help="who found it")
    add("--photo", type=Path, metavar="FILE", help="photograph, which is copied into the survey")
    add("--remark", default="", metavar="TEXT", help="one line, such as the model of the device")
    add("--markers", type=arguments.path_with(*ENDINGS), action="append", default=[],
        metavar="FILE", help="write the markers as .csv, .json or .geojson; may be given more than "
        "once")  # fmt: skip
    arguments.add_overwrite(parser)


def _annotate(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    survey = chosen.survey
    if not survey.is_dir():
        no_folder = Message("{path} is no folder; only a survey's folder takes notes", path=survey)
        raise AnalysisError(no_folder if survey.exists() else not_there(survey), fault=errors.INPUT)
    given = [one is not None for one in (chosen.found, chosen.list, chosen.what)]
    if any(given) and not all(given):
        raise AnalysisError(Message("give --found, --list and --what, or none of them"))
    if all(given) and not chosen.who:
        raise AnalysisError(Message("give the name of who found it with --who"))
    if chosen.photo is not None:
        check_ending(chosen.photo.with_suffix(chosen.photo.suffix.lower()), PHOTO_ENDINGS)
    written = [one for path in chosen.markers for one in output_paths(path)]
    arguments.check_outputs(written, [survey], chosen.overwrite)
    changes = {name: getattr(chosen, name) for name in NAMES if hasattr(chosen, name)}
    # First, so that nothing is stored of a request that is refused.
    found_fact = _found_fact(chosen) if all(given) else None
    if changes:
        # What another program annotated meanwhile stays.
        _add(survey, lambda there: Fact(
            Kind.ANNOTATION, replace(annotation_of(there), **changes).values()
        ))  # fmt: skip
    if found_fact is not None:
        _add(survey, found_fact)
    description = read_description(survey)
    annotation = annotation_of(description)
    markers = marker_list(description, _area_position(annotation))
    for path in chosen.markers:
        write_markers(markers, path)
    values = {name: getattr(annotation, name) for name in NAMES}
    texts = {name: "-" if one in (None, "") else str(one) for name, one in values.items()}
    print_rows([(verbatim(name), verbatim(text)) for name, text in texts.items()], catalogue)
    lines = marker_lines(markers, catalogue) if markers.markers else []
    for line in [*lines, *map("  ".join, found_rows(survey))]:
        say(line)
    return DONE


def _add(folder: Path, fact_of: Callable[[Dict[str, Any]], Fact]) -> None:
    """Add a fact to the survey.

    Raises:
        AnalysisError: It has not ended.
    """

    def change(description: Dict[str, Any]) -> Fact:
        if description.get("ended") is None:
            raise AnalysisError(
                Message(
                    "the survey in {folder} has not ended, and a robot may be writing it; use the "
                    "robot's window, or resume and stop the survey first",
                    folder=folder,
                ),
                fault=IN_USE,
            )
        return fact_of(description)

    add_to_survey(folder, change, _now())


def _now() -> str:
    return utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)


def _found_fact(chosen: argparse.Namespace) -> Callable[[Dict[str, Any]], Fact]:
    photo = None if chosen.photo is None else read_regular(chosen.photo)
    name = ""
    if photo is not None:
        name = hashlib.sha256(photo).hexdigest() + chosen.photo.suffix.lower()
    found = Found(
        What(chosen.what),
        **_candidate(chosen),
        who=chosen.who,
        time=_now(),
        depth_mm=chosen.depth_mm,
        photo=name,
        notes=chosen.remark,
    )

    def fact_of(_description: Dict[str, Any]) -> Fact:
        if photo is not None:  # durable before the record that names it
            folder = chosen.survey / PHOTOS
            durable_files.ensure_folder(folder)
            durable_files.write_new_file(folder / name, photo)
        return Fact(Kind.FOUND, found.values())

    return fact_of


def _candidate(chosen: argparse.Namespace) -> Dict[str, Any]:
    """Return id and place of the candidate, and its list: ids depend on how an image is made."""
    content = read_regular(chosen.list)
    survey_id = read_description(chosen.survey)["survey_id"]
    listed = list_from(content.decode("utf-8", "replace"), survey_id).candidates
    for one in listed:
        if one.id == chosen.found:
            own = hashlib.sha256(content).hexdigest()
            return {"x_mm": one.x_mm, "y_mm": one.y_mm, "candidate": one.id, "list_sha256": own}
    ids = ", ".join(one.id for one in listed)
    other = Message("there is no candidate {id}; write {ids}", id=chosen.found, ids=ids)
    raise AnalysisError(other, fault=errors.INPUT)


def _area_position(annotation: Annotation) -> Optional[AreaPosition]:
    at, heading_deg = annotation.position, annotation.heading_deg
    if at is None or heading_deg is None:
        return None
    return AreaPosition(at.latitude_deg, at.longitude_deg, heading_deg)


def _heading(text: str) -> Optional[float]:
    return number(text) if text else None


def _position(text: str) -> Optional[Wgs84Position]:
    try:
        return position_from_text(text) if text else None
    except InvalidValueError as error:
        # argparse shows the text of this error, but not that of a ValueError.
        raise argparse.ArgumentTypeError(str(error)) from None


ANNOTATE = Command(
    "Set name, operator, site, notes, position and heading of a survey, and note what was found at "
    "a candidate: nothing, scrap or a device. What is not given stays; all that people added is "
    "printed, markers too. A later record of the same candidate replaces an earlier one, which "
    "stays in the log. A survey of which noted entries are lost is refused.",
    _add_arguments,
    _annotate,
)
