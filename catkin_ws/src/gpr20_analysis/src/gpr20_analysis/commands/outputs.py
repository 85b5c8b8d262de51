"""The outputs of a subcommand: checked before any work, replaced only with --overwrite."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Iterable, Sequence

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import ExportError, check_ending
from gpr20_common.message import Message
from gpr20_survey.folder import survey_folder

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


def check(outputs: Iterable[Path], inputs: Sequence[Path], overwrite: bool) -> None:
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
