"""The subcommands of gpr20: their table, and what each is made of."""

from __future__ import annotations

import argparse
import importlib
from dataclasses import dataclass
from typing import Callable, Dict, Iterable, Tuple

from gpr20_analysis import errors
from gpr20_analysis.entry_points import ExtensionPoint, additions
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say

DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
EXIT_STATUS = (
    "exit status: 0 done, 1 survey not complete or not sealed, 2 survey damaged, 3 refused or "
    "failed; the message gives the reason"
)
TITLE_WIDTH = 24


@dataclass(frozen=True)
class Command:
    """One subcommand."""

    description: str
    """Description for --help."""
    add_arguments: Callable[[argparse.ArgumentParser], None]
    """Declares the arguments."""
    run: Callable[[argparse.Namespace, Catalogue], int]
    """Runs the subcommand, with texts in the language of the catalogue; returns the exit status."""
    exit_status: str = EXIT_STATUS
    """What the exit status means, for --help."""


SUMMARIES: Dict[str, Tuple[str, str]] = {
    "info": ("survey", "show what a survey contains and what is missing in it"),
    "process": ("image", "apply a chain of steps and store the result"),
    "image": ("image", "image the ground below a survey and list the candidates in it"),
    "candidates": ("image", "list the candidates in the ground below a survey, also in files"),
    "hiding": ("report", "map where a mine could hide from the survey's own detector"),
    "delay": ("antenna", "fit the delay of cables and antennas to the surface echo"),
    "antenna": ("antenna", "fit the model of the antennas to surveys of a metal plate"),
    "plot": ("image", "draw a survey or its A-scans"),
    "annotate": ("annotate", "note name, site, position and finds of a survey; list markers"),
    "verify": ("survey", "check a survey's folder, and repair its log and manifest"),
    "sign": ("survey", "sign a survey as it is now"),
    "export": ("file", "write a survey in another format: NetCDF, CSV, ROS"),
    "import": ("file", "read measurements and simulations of other programs as a survey"),
    "report": ("report", "write one page with everything about a survey"),
    "sample": ("file", "write a copy of a small simulated survey, to try the other commands on"),
    "doctor": ("robot", "find what is wrong with the robot and this computer"),
    "replay": ("robot", "publish a recorded survey on its ROS topics"),
}
"""Module (`<module>_commands`) and summary of each subcommand of this package.

The subcommand is the constant of its name there, such as INFO.
"""
ENGLISH = {"annotate", "antenna", "delay", "export", "import", "process"} | {
    *("replay", "sample", "sign", "view")
}
"""Subcommands that say nothing of what operators read in their language."""
COMMANDS = ExtensionPoint(
    "gpr20.commands",
    Message("the command"),
    fault=errors.STEPS,
    own=SUMMARIES,
    wings={"view": "gpr20_viewer"},
    kind=Command,
)
"""By this, other packages add subcommands."""


def summaries() -> Dict[str, str]:
    """Return name and summary of every subcommand; nothing of other packages is imported."""
    own = {name: summary for name, (_module, summary) in SUMMARIES.items()}
    absent = {
        name: f"(of {package}, which is not installed)" for name, package in COMMANDS.wings.items()
    }
    added = {one.name: one.summary for one in additions(COMMANDS.group)}
    # In this order: no package replaces a subcommand of this one.
    return {**own, **absent, **added, **own}


def load(name: str) -> Command:
    """Return the subcommand with a name of `summaries()`.

    Raises:
        MissingLibraryError: Its package is not installed.
        AnalysisError: There is none, its package cannot be used, or another one has the same name.
    """
    if name in SUMMARIES:
        module = importlib.import_module(f"gpr20_analysis.commands.{SUMMARIES[name][0]}_commands")
        own: Command = getattr(module, name.upper())
        return own
    added: Command = COMMANDS.load(COMMANDS.addition(name))
    return added


def parser_of(name: str, command: Command) -> argparse.ArgumentParser:
    """Return the parser of a subcommand's arguments."""
    parser = argparse.ArgumentParser(
        prog=f"gpr20 {name}", description=command.description, epilog=command.exit_status
    )
    parser.register("type", float, number)
    command.add_arguments(parser)
    return parser


def number(text: str) -> float:
    """Return the number of an option, also as people write it who have decimal commas."""
    return float(text if "." in text else text.replace(",", "."))


def per(units: float) -> Callable[[str], float]:
    """Return the type of an option that is given in another unit, of which so many are one."""

    def of_text(text: str) -> float:
        return number(text) / units

    of_text.__name__ = number.__name__  # as argparse names the type
    return of_text


def print_rows(rows: Iterable[Tuple[Message, Message]], catalogue: Catalogue) -> None:
    """Print title and text of each row; a text of several lines is indented."""
    for title, text in rows:
        first, *more = catalogue.text(text).splitlines() or [""]
        say(f"{catalogue.text(title) + ': ':{TITLE_WIDTH}}{first}".rstrip())
        for line in more:
            say(f"{'':{TITLE_WIDTH}}{line}".rstrip())
