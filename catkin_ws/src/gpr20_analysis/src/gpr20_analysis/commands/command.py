"""The subcommands of gpr20."""

from __future__ import annotations

import argparse
import importlib
from dataclasses import dataclass
from typing import Callable, Dict, Iterable, Tuple

from gpr20_analysis import faults
from gpr20_analysis.entry_points import ExtensionPoint, additions
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say

DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
TITLE_WIDTH = 24
EXIT_STATUS = (
    "exit status: 0 done, 1 survey not complete or not sealed, 2 survey damaged, 3 refused or "
    "failed; the message gives the reason"
)


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


MODULES = "gpr20_analysis.commands"

SUMMARIES: Dict[str, str] = {
    "info": "show what a survey contains and what is missing in it",
    "process": "apply a chain of steps and store the result",
    "image": "image the ground below a survey and list the candidates in it",
    "candidates": "list the candidates in the ground below a survey, and write them to files",
    "hiding": "map where a mine could hide from the survey's own detector",
    "delay": "fit the delay of cables and antennas to the surface echo",
    "antenna": "fit the model of the antennas to surveys of a metal plate",
    "plot": "draw a survey or its A-scans",
    "annotate": "note name, site and position of a survey, and what was found; list markers",
    "trial": "score lists of candidates against buried targets",
    "verify": "check a survey's folder against its manifest, recordings and plan, and repair it",
    "sign": "sign a survey as it is now",
    "export": "write a survey in another format: NetCDF, CSV, SEG-Y, Touchstone, ROS",
    "import": "read measurements and simulations of other programs as a survey",
    "report": "write one page with everything about a survey",
    "batch": "run a command on many surveys side by side",
    "sample": "write a copy of a small simulated survey, to try the other commands on",
    "doctor": "find what is wrong with the robot and this computer",
    "replay": "publish a recorded survey on its ROS topics",
}
"""Name and summary of each subcommand of this package; its module is `<name>_command`."""

ENGLISH = {"annotate", "antenna", "delay", "export", "import", "process"} | {
    *("replay", "sample", "sign", "trial", "view")
}
"""Subcommands that say nothing of what operators read in their language."""

COMMANDS = ExtensionPoint(
    "gpr20.commands",
    Message("the command"),
    fault=faults.STEPS,
    own=SUMMARIES,
    wings={"view": "gpr20_viewer"},
    kind=Command,
)
"""By this, other packages add subcommands."""


def summaries() -> Dict[str, str]:
    """Return name and summary of every subcommand; nothing of other packages is imported."""
    absent = {
        name: f"(of {package}, which is not installed)" for name, package in COMMANDS.wings.items()
    }
    added = {one.name: one.summary for one in additions(COMMANDS.group)}
    # In this order: no package replaces a subcommand of this one.
    return {**SUMMARIES, **absent, **added, **SUMMARIES}


def load(name: str) -> Command:
    """Return the subcommand with a name of `summaries()`.

    Raises:
        MissingLibraryError: Its package is not installed.
        AnalysisError: Its package cannot be used, or another one has the same name.
    """
    if name in SUMMARIES:
        module = importlib.import_module(f"{MODULES}.{name}_command")
        own: Command = module.COMMAND
        return own
    added: Command = COMMANDS.load(COMMANDS.addition(name))
    return added


def print_rows(rows: Iterable[Tuple[Message, Message]], catalogue: Catalogue) -> None:
    """Print title and text of each row; a text of several lines is indented."""
    for title, text in rows:
        first, *more = catalogue.text(text).splitlines() or [""]
        say(f"{catalogue.text(title) + ':':{TITLE_WIDTH}}{first}".rstrip())
        for line in more:
            say(f"{'':{TITLE_WIDTH}}{line}".rstrip())
