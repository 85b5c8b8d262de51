"""gpr20 view: a window with B-scan, sections and slices of a survey."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from gpr20_analysis.commands import image_options, report_commands
from gpr20_analysis.commands.command import Command
from gpr20_analysis.errors import NO_SCREEN, AnalysisError, MissingLibraryError, library_missing
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_viewer.picks_file import picks_path
from gpr20_viewer.session import ViewSession

PACKAGE, EXTRA = "gpr20_viewer", "qt"
LIBRARIES = {"PyQt5": "PyQt5", "pyqtgraph": "pyqtgraph"}
"""Libraries that the window needs; without them nothing is loaded first."""
OPEN_SCREEN = """
import resource
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
from PyQt5.QtGui import QGuiApplication
QGuiApplication([])
"""
SCREEN_LIMIT_S = 15.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    image_options.add_options(parser)
    report_commands.add_hiding(parser)
    add = parser.add_argument
    add("--picks", type=Path, metavar="FILE",
        help="file of the picks; default SURVEY.picks.json beside the survey")  # fmt: skip
    add("--author", default="", metavar="NAME", help="who picks; stored with each pick")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Show the window; return the exit status when it was closed."""
    _check_libraries()
    _check_screen()
    options = image_options.options_of(chosen)
    steps = image_options.steps_of(chosen)
    survey, status = image_options.processed(chosen, options, steps, catalogue)
    session = ViewSession(survey, options, report_commands.hiding_of(chosen, survey))
    from gpr20_viewer.views.main_window import show

    picks = chosen.picks or picks_path(chosen.survey)
    name = chosen.survey.expanduser().resolve().name
    show(session, picks, chosen.author, name)
    return status


def _check_libraries() -> None:
    for module, library in LIBRARIES.items():
        try:
            __import__(module)
        except ImportError as error:
            raise MissingLibraryError(library_missing(library, EXTRA, PACKAGE)) from error


def _check_screen() -> None:
    # Qt ends the whole program, with a core dump, where it cannot open a screen.
    if not sys.platform.startswith("linux"):
        return
    try:
        subprocess.run(
            [sys.executable, "-c", OPEN_SCREEN], capture_output=True, text=True, check=True,
            timeout=SCREEN_LIMIT_S,
        )  # fmt: skip
    except subprocess.SubprocessError as error:
        said = str(getattr(error, "stderr", None) or error).splitlines()
        raise AnalysisError(
            Message("there is no screen here", details=said[0]), fault=NO_SCREEN
        ) from error


COMMAND = Command(
    "Look at a survey in a window: B-scan, sections and slices, with a permittivity slider. "
    "Picks are stored beside the survey, never in its folder.",
    add_arguments,
    run,
)
