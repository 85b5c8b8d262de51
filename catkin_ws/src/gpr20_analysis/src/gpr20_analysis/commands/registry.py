"""The subcommands of gpr20 by name.

Only the module of the chosen one is imported, so a command needs no library of another one.
"""

from __future__ import annotations

import importlib
from typing import Dict

from gpr20_analysis.commands.command import Command

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
