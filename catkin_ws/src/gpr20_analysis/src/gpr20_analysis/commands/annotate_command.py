"""gpr20 annotate: set name, operator, site, notes, position and heading of a recorded survey."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Tuple

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DONE, Command, print_rows
from gpr20_analysis.errors import AnalysisError, not_there
from gpr20_analysis.report.summary import HEADING_OF_Y, POSITION, RECORDED, heading_text
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import IN_USE
from gpr20_common.message import Message, verbatim
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import Fact, add_to_survey, read_description
from gpr20_survey.plan.annotation import (
    Annotation,
    Wgs84Position,
    annotation_of,
    position_from_text,
)
from gpr20_survey.trace import utc_time

NONE = verbatim("-")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("survey", type=Path, help="folder of a survey that has ended")
    parser.add_argument("--name", help="what the survey is called; its folder stays as it is")
    parser.add_argument("--operator", metavar="NAME", help="who measured")
    parser.add_argument("--site", metavar="NAME", help="where, in words")
    parser.add_argument("--notes", metavar="TEXT", help="everything else; may have several lines")
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--position",
        metavar="LAT,LON",
        type=_position,
        help="where: WGS 84 latitude and longitude in degrees, north and east positive; "
        "with a negative latitude write --position=LAT,LON",
    )
    place.add_argument("--no-position", action="store_true", help="remove the position")
    direction = parser.add_mutually_exclusive_group()
    direction.add_argument(
        "--heading",
        metavar="DEG",
        type=float,
        help="direction of +Y, clockwise from true north, 0 to 360; +X is 90 degrees to its right",
    )
    direction.add_argument("--no-heading", action="store_true", help="remove the heading")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Change what is given, print the whole annotation and return the exit status."""
    if not chosen.survey.is_dir():
        raise AnalysisError(not_there(chosen.survey), fault=faults.INPUT)
    description = read_description(chosen.survey)
    changes = _changes(chosen)
    if changes:

        def change(present: Dict[str, Any]) -> Fact:
            refuse_open(chosen.survey, present)
            # What another program annotated meanwhile stays.
            return Fact(Kind.ANNOTATION, replace(annotation_of(present), **changes).values())

        now = utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)
        description = add_to_survey(chosen.survey, change, now)
    print_rows(_rows(annotation_of(description)), catalogue)
    return DONE


def _changes(chosen: argparse.Namespace) -> Dict[str, Any]:
    names = {"name": "name", "operator": "operator", "site": "site", "notes": "notes",
             "position": "position", "heading_deg": "heading"}  # fmt: skip
    given = {name: getattr(chosen, option) for name, option in names.items()}
    changes = {name: value for name, value in given.items() if value is not None}
    if chosen.no_position:
        changes["position"] = None
    if chosen.no_heading:
        changes["heading_deg"] = None
    return changes


def refuse_open(folder: Path, description: Dict[str, Any]) -> None:
    """Refuse to change a survey that has not ended.

    Raises:
        AnalysisError: It has not ended.
    """
    if description.get("ended") is None:
        raise AnalysisError(
            Message(
                "the survey in {folder} has not ended, and a robot may be writing it; use the "
                "robot's window, or resume and stop the survey first",
                folder=folder,
            ),
            fault=IN_USE,
        )


def _rows(annotation: Annotation) -> List[Tuple[Message, Message]]:
    position = annotation.position
    texts = {
        RECORDED["survey_name"]: annotation.name,
        RECORDED["operator"]: annotation.operator,
        RECORDED["site"]: annotation.site,
        RECORDED["survey_notes"]: annotation.notes,
        POSITION: "" if position is None else str(position),
    }
    heading = NONE if annotation.heading_deg is None else heading_text(annotation.heading_deg)
    rows = [(title, verbatim(text) if text else NONE) for title, text in texts.items()]
    return [*rows, (HEADING_OF_Y, heading)]


def _position(text: str) -> Wgs84Position:
    try:
        return position_from_text(text)
    except InvalidValueError as error:
        # argparse shows the text of this error, but not that of a ValueError.
        raise argparse.ArgumentTypeError(str(error)) from None


COMMAND = Command(
    "Set name, operator, site, notes, position and heading of a survey. What is not given stays; "
    "without any, they are printed. A survey of which noted entries are lost is refused.",
    add_arguments,
    run,
)
