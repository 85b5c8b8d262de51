"""The subcommands of gpr20: their table, what each is made of, and what it says when it fails."""

from __future__ import annotations

import argparse
import importlib
from dataclasses import dataclass
from typing import Callable, Dict, Iterable, List, Tuple

from gpr20_analysis import faults
from gpr20_analysis.entry_points import ExtensionPoint, additions
from gpr20_analysis.errors import library_missing
from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import ASKED_FOR, DISK_REFUSES, NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.faults import NOT_SIGNED

DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
EXIT_STATUS = (
    "exit status: 0 done, 1 survey not complete or not sealed, 2 survey damaged, 3 refused or "
    "failed; the message gives the reason"
)
TITLE_WIDTH = 24
EXTRAS = {"distributed": "batch", "matplotlib": "plots"}
"""Optional libraries that whole commands need, and the extra of each."""
EXPECTED = (Gpr20Error, OSError, MemoryError, ModuleNotFoundError)
"""Errors whose message is sufficient; all others are program errors."""
TRACEBACK = "GPR20_TRACEBACK"
"""Environment variable: if set, a program error prints its traceback."""
STEP_IS_SAID = frozenset(
    one.code
    for one in (
        *(NOT_ALLOWED, ASKED_FOR, faults.INPUT, faults.STEPS, faults.TOO_LARGE),
        *(faults.NO_ROS, faults.ROBOT_RUNS, faults.PROGRAM, NOT_SIGNED),
    )
)
"""Codes whose remedy says in general what each of their sentences says exactly."""


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
    "plot": ("plot", "draw a survey or its A-scans"),
    "annotate": ("annotate", "note name, site, position and finds of a survey; list markers"),
    "trial": ("trial", "score lists of candidates against buried targets"),
    "verify": ("survey", "check a survey's folder, and repair its log and manifest"),
    "sign": ("survey", "sign a survey as it is now"),
    "export": ("file", "write a survey in another format: NetCDF, CSV, SEG-Y, Touchstone, ROS"),
    "import": ("file", "read measurements and simulations of other programs as a survey"),
    "report": ("report", "write one page with everything about a survey"),
    "batch": ("batch", "run a command on many surveys side by side"),
    "sample": ("file", "write a copy of a small simulated survey, to try the other commands on"),
    "doctor": ("robot", "find what is wrong with the robot and this computer"),
    "replay": ("robot", "publish a recorded survey on its ROS topics"),
}
"""Module (`<module>_commands`) and summary of each subcommand of this package.

The subcommand is the constant of its name there, such as INFO.
"""
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
    return lambda text: number(text) / units


def message_of(error: BaseException, command: str) -> Message:
    """Return what went wrong.

    Args:
        error: Ended the command.
        command: What was called, such as "gpr20 info x".
    """
    file = error.filename if isinstance(error, OSError) else None
    if isinstance(error, Gpr20Error):
        reason = error.message
    elif isinstance(error, KeyboardInterrupt):
        return Message("interrupted; no partial output is left").with_fault(ASKED_FOR)
    elif isinstance(error, ModuleNotFoundError):
        name = error.name or ""
        missing = library_missing(name, EXTRAS.get(name.split(".")[0], ""))
        return missing.with_fault(faults.STEPS)
    elif isinstance(error, MemoryError):
        message = Message("not enough memory; use fewer samples", details=error)
        return message.with_fault(faults.TOO_LARGE)
    elif isinstance(error, OSError):
        reason = os_reason(error)
        reason = reason if reason.cause else reason.with_fault(DISK_REFUSES)
    else:
        return Message(
            "program error {error}; please report it with the output of {command}",
            error=f"{type(error).__name__}: {error}",
            command=f"{TRACEBACK}=1 {command}",
        ).with_fault(faults.PROGRAM)
    return Message("{file}: {reason}", file=file, reason=reason) if file else reason


def first_steps(message: Message) -> List[Message]:
    """Return what to do first; nothing if the message says it, or if that is not known."""
    cause = message.cause
    if cause is None or cause.remedy is None or cause.code in STEP_IS_SAID:
        return []
    return [Message("First: {remedy}", remedy=cause.remedy)]


def print_rows(rows: Iterable[Tuple[Message, Message]], catalogue: Catalogue) -> None:
    """Print title and text of each row; a text of several lines is indented."""
    for title, text in rows:
        first, *more = catalogue.text(text).splitlines() or [""]
        say(f"{catalogue.text(title) + ':':{TITLE_WIDTH}}{first}".rstrip())
        for line in more:
            say(f"{'':{TITLE_WIDTH}}{line}".rstrip())
