"""The arguments of most subcommands: a survey with its warnings, and outputs.

Outputs are checked before any work, and replaced only with --overwrite.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Iterable, Optional, Sequence

import xarray as xr
from tqdm import tqdm

from gpr20_analysis import errors
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands.command import DAMAGED, DONE, NOT_COMPLETE
from gpr20_analysis.dataset import ANTENNA
from gpr20_analysis.errors import ExportError, WrongDatasetError, check_ending
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sentences import DOUBTS, LIST_ATTRIBUTES, labelled, limited, sentences_of, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable, say
from gpr20_survey.folder import survey_folder

MOST_REMARKS = 8
"""Number of sentences of a list that are shown with a survey."""


def add_survey(parser: argparse.ArgumentParser) -> None:
    """Declare the survey, and whether it may be damaged."""
    parser.add_argument(
        "survey",
        type=Path,
        help="folder of a survey, folder of its JSON files, .bag, .bag.active, .mcap, or .nc",
    )
    parser.add_argument(
        "--accept-damaged",
        action="store_true",
        help="mark damaged samples and leave them out, instead of refusing the survey",
    )


def load(chosen: argparse.Namespace, catalogue: Catalogue) -> xr.Dataset:
    """Load the survey and print on stderr what is missing or damaged in it.

    Raises:
        AnalysisError: It cannot be loaded.
    """
    progress = progress_bar("reading traces")
    survey = load_survey(chosen.survey, chosen.accept_damaged, progress)
    if ANTENNA in survey:
        raise WrongDatasetError(
            Message(
                "{path} is a model of antennas and no survey; use it with --antenna",
                path=chosen.survey,
            ),
            fault=errors.INPUT,
        )
    print_warnings(survey, catalogue)
    return survey


def status_of(survey: xr.Dataset) -> int:
    """Return the exit status for a survey."""
    if survey.attrs.get("faults"):
        return DAMAGED
    return NOT_COMPLETE if survey.attrs.get("missing") else DONE


def print_warnings(survey: xr.Dataset, catalogue: Catalogue, path: str = "") -> None:
    """Print on stderr what is damaged, missing, doubted or noted in a survey.

    All doubts, and of other lists the first sentences.

    Args:
        survey: The survey.
        catalogue: Language of the output.
        path: Where it was read from, if it is not the survey of the command.
    """
    for name in LIST_ATTRIBUTES:
        found = sentences_of(survey, name)
        for one in found if name == DOUBTS else limited(found, MOST_REMARKS):
            sentence = Message("{file}: {reason}", file=path, reason=one) if path else one
            say(shown(labelled(name, sentence), catalogue), file=sys.stderr)


def progress_bar(what: str) -> Any:
    """Return a `Progress` that draws a bar on a terminal and nothing elsewhere."""

    def drawn(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
        return tqdm(items, total=total, desc=printable(what), disable=None, leave=False)

    return drawn


if TYPE_CHECKING:
    from matplotlib.figure import Figure

DESCRIBED_BY = (*survey_folder.LOG_FILES, survey_folder.SURVEY_FILE)
PICTURES = (".png", ".svg", ".pdf")
RESOLUTION_DPI = 300


def add_output(
    parser: argparse.ArgumentParser, endings: Sequence[str], meaning: str, **named: Any
) -> None:
    """Declare an output, which has one of the endings, and the option to replace it."""
    parser.add_argument("--output", "-o", type=path_with(*endings), help=meaning, **named)
    add_overwrite(parser)


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Declare the option to replace existing outputs."""
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace existing files, which are refused otherwise",
    )


def path_with(*endings: str) -> Callable[[str], Path]:
    """Return the type of an argument that is a path with one of the endings."""

    def path_of(text: str) -> Path:
        path = Path(text)
        check_ending(path, endings)
        return path

    return path_of


def check_outputs(outputs: Iterable[Path], inputs: Sequence[Path], overwrite: bool) -> None:
    """Check that outputs can and may be written.

    Args:
        outputs: Files and folders that the command writes.
        inputs: Its inputs, which are never written.
        overwrite: Whether existing files may be replaced; a folder with something in it never is.

    Raises:
        ExportError: An output cannot or must not be written.
    """
    for path in outputs:
        place = path.absolute().parent.resolve() / path.name
        if place in [one.resolve() for one in inputs]:
            raise ExportError(
                Message("{path} is an input of this command; choose another output", path=path)
            )
        _check_outside_of_surveys(path, place)
        _check_free(path, place, overwrite)


def _check_outside_of_surveys(path: Path, place: Path) -> None:
    for folder in place.parents:
        is_described = any((folder / name).exists() for name in DESCRIBED_BY)
        if is_described and (folder / survey_folder.TRACES_FOLDER).exists():
            raise ExportError(
                Message(
                    "{path} is in the folder of the survey {folder}, which is for measured data "
                    "only; choose another place",
                    path=path,
                    folder=folder,
                )
            )


def _check_free(path: Path, place: Path, overwrite: bool) -> None:
    if path.is_dir() and any(path.iterdir()):
        raise ExportError(
            Message("{path} is a folder with files in it; choose a new one", path=path)
        )
    if os.path.lexists(str(place)) and not path.is_dir() and not overwrite:
        raise ExportError(
            Message(
                "{path} exists; replace it with --overwrite, or choose another place", path=path
            )
        )
    above = next(one for one in place.parents if one.exists())
    if not (above.is_dir() and os.access(str(above), os.W_OK | os.X_OK)):
        raise ExportError(
            Message(
                "{path} cannot be written: {above} is no folder or read-only; choose another place",
                path=path,
                above=above,
            )
        )


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the path's ending.

    Raises:
        OSError: It cannot be written.
    """
    with atomic_output(path) as place:
        figure.savefig(str(place), dpi=RESOLUTION_DPI)
