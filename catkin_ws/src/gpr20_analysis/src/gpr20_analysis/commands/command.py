"""What a subcommand of gpr20 is."""

from __future__ import annotations

import argparse
import importlib
from dataclasses import dataclass
from typing import Callable, Dict

DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
EXIT_STATUS = (
    "exit status: 0 done, 1 survey intact but not complete, 2 survey damaged, 3 refused or failed; "
    "the message says why"
)


@dataclass(frozen=True)
class Command:
    """One subcommand; a module of this package holds it as COMMAND."""

    description: str
    """What it does, for its --help."""
    add_arguments: Callable[[argparse.ArgumentParser], None]
    """Declares its arguments."""
    run: Callable[[argparse.Namespace], int]
    """Does it and returns the exit status; errors of this project are raised."""


MODULES = "gpr20_analysis.commands"

SUMMARIES: Dict[str, str] = {
    "info": "what a survey holds and what is missing in it",
    "process": "apply a chain of steps and keep the result with its recipe",
    "image": "image the ground below a survey and name the echoes in it",
    "plot": "draw a survey, its A-scans or an image",
    "verify": "check a survey's folder against its manifest, recordings and plan",
    "export": "a survey in a format of others: NetCDF, HDF5, CSV, SEG-Y, Touchstone, JSON",
    "import": "measurements and simulations of others as a survey",
    "report": "one page with everything about a survey",
    "replay": "a recorded survey back onto its ROS topics",
}
"""Name of each subcommand and what it does; its module is `<name>_command`."""


def load(name: str) -> Command:
    """Return the subcommand of a name of `SUMMARIES`."""
    return importlib.import_module(f"{MODULES}.{name}_command").COMMAND
