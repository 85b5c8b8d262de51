"""Name, operator, site, notes and position on the command line of the terminal client."""

from __future__ import annotations

import argparse
from typing import Any, Callable, Dict, List

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.plan.annotation import Annotation, position_from_text


def argument_reader(read: Callable[[str], Any], catalogue: Catalogue) -> Callable[[str], Any]:
    """Return a function for argparse that reads an argument.

    Args:
        read: Reads it; raises InvalidValueError if it is not allowed.
        catalogue: Language of the messages.
    """

    def read_argument(text: str) -> Any:
        try:
            return read(text)
        except InvalidValueError as error:
            # argparse shows the text of this error, but not that of a ValueError.
            raise argparse.ArgumentTypeError(catalogue.text(error.message)) from None

    return read_argument


_HELP = {
    "name": Message("what the survey is called"),
    "operator": Message("who measures (default: that of the robot)"),
    "site": Message("where, in words (default: that of the robot)"),
    "notes": Message("notes on the survey"),
    "position": Message(
        "WGS 84 latitude and longitude in degrees; with a negative latitude write "
        "--position=LAT,LON"
    ),
}
_READ: Dict[str, Callable[[str], Any]] = {
    "name": lambda text: Annotation(name=text).name,
    "operator": lambda text: Annotation(operator=text).operator,
    "site": lambda text: Annotation(site=text).site,
    "notes": lambda text: Annotation(notes=text).notes,
    "position": position_from_text,
}
_METAVARS = {"notes": "TEXT", "position": "LAT,LON"}


def add_annotation(group: argparse._ArgumentGroup, catalogue: Catalogue) -> List[argparse.Action]:
    """Declare the arguments.

    Args:
        group: Where they are listed in the help.
        catalogue: Language of the help and of the messages.
    """
    return [
        group.add_argument(
            f"--{name}",
            type=argument_reader(_READ[name], catalogue),
            metavar=_METAVARS.get(name, "NAME"),
            help=catalogue.text(text),
        )
        for name, text in _HELP.items()
    ]


def annotation_from(given: argparse.Namespace) -> Annotation:
    """Return what was given; the rest is empty."""
    texts = {name: getattr(given, name) or "" for name in ("name", "operator", "site", "notes")}
    return Annotation(**texts, position=given.position, heading_deg=None)
