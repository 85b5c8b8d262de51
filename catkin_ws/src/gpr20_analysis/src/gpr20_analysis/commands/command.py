"""The subcommands of gpr20."""

from __future__ import annotations

import argparse
import importlib
from dataclasses import dataclass
from typing import Callable, Dict

from gpr20_analysis import faults
from gpr20_analysis.entry_points import Addition, additions
from gpr20_analysis.errors import AnalysisError, MissingLibraryError
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
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
    "process": "apply a chain of steps and store the result with its recipe",
    "image": "image the ground below a survey and list the candidates in it",
    "candidates": "list the candidates in the ground below a survey, and write them to files",
    "delay": "fit the delay of cables and antennas to the surface echo",
    "plot": "draw a survey, its A-scans or an image",
    "annotate": "set operator, site, notes and position of a survey",
    "markers": "list the markers that people set in a survey, and write them to files",
    "verify": "check a survey's folder against its manifest, recordings and plan",
    "repair": "write a lost or damaged manifest again if everything else agrees",
    "export": "write a survey in another format: NetCDF, HDF5, CSV, SEG-Y, Touchstone, JSON",
    "import": "read measurements and simulations of other programs as a survey",
    "report": "write one page with everything about a survey",
    "batch": "run a command on many surveys side by side",
    "sample": "write a copy of a small simulated survey, to try the other commands on",
    "doctor": "find what is wrong with the robot and this computer",
    "replay": "publish a recorded survey on its ROS topics",
}
"""Name and summary of each subcommand of this package; its module is `<name>_command`."""

ENTRY_POINTS = "gpr20.commands"
"""Group of the entry points by which other packages add subcommands, each a `Command`."""
WINGS = {"view": "gpr20_viewer"}
"""Subcommands of this project's packages that are installed only where they are wanted."""


def summaries() -> Dict[str, str]:
    """Return name and summary of every subcommand; nothing of other packages is imported."""
    absent = {name: f"(of {package}, which is not installed)" for name, package in WINGS.items()}
    added = {one.name: one.summary for one in additions(ENTRY_POINTS)}
    # In this order: no package replaces a subcommand of this one.
    return {**SUMMARIES, **absent, **added, **SUMMARIES}


def load(name: str) -> Command:
    """Return the subcommand with a name of `summaries()`.

    Raises:
        MissingLibraryError: Its package is not installed.
        AnalysisError: Its package cannot be used, or another one has the same name.
    """
    if name in SUMMARIES:
        return importlib.import_module(f"{MODULES}.{name}_command").COMMAND
    found = [one for one in additions(ENTRY_POINTS) if one.name == name]
    if not found:
        raise MissingLibraryError(
            Message(
                "this command is of the package {package}, which is not installed; in a clone of "
                "the project, install it with: pip install 'catkin_ws/src/{package}'",
                package=WINGS[name],
            )
        )
    if len(found) > 1:
        raise AnalysisError(
            Message(
                "several installed packages have the command '{command}': {origins}",
                command=name,
                origins="; ".join(one.origin for one in found),
            ),
            fault=faults.OWN_COMMAND,
        )
    return _added(found[0])


def _added(addition: Addition) -> Command:
    try:
        loaded = addition.load()
    except Exception as error:  # the package is not ours: it may raise anything
        raise AnalysisError(
            Message(
                "the command '{command}' ({origin}) cannot be loaded: {reason}",
                command=addition.name,
                origin=addition.origin,
                reason=f"{type(error).__name__}: {error}",
            ),
            fault=faults.OWN_COMMAND,
        ) from error
    if not isinstance(loaded, Command):
        raise AnalysisError(
            Message(
                "the command '{command}' ({origin}) is a {type}; it must be a {expected}",
                command=addition.name,
                origin=addition.origin,
                type=type(loaded).__name__,
                expected=f"{Command.__module__}.{Command.__name__}",
            ),
            fault=faults.OWN_COMMAND,
        )
    return loaded
