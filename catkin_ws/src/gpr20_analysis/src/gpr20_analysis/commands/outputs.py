"""The outputs of a subcommand: checked before any work, replaced only with --overwrite."""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, List, Sequence

from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_analysis.formats.dataset_files import NETCDF
from gpr20_common.message import Message
from gpr20_survey.folder import survey_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DESCRIBED_BY = (*survey_folder.LOG_FILES, survey_folder.SURVEY_FILE)
FORMATS = (".png", ".svg", ".pdf")
RESOLUTION_DPI = 300


@dataclass(frozen=True)
class Output:
    """One file or folder that a subcommand writes.

    Attributes:
        path: File or folder.
        holds: Patterns of the names in a folder; one with other names is not replaced. Empty: a
            file.
    """

    path: Path
    holds: Sequence[str] = ()


def dataset_output(path: Path) -> Output:
    """Return the output of a Dataset.

    Raises:
        ExportError: The path has another ending than .nc.
    """
    if path.suffix != NETCDF:
        raise ExportError(wrong_ending(path, (NETCDF,)))
    return Output(path)


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Declare the option to replace existing outputs."""
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace existing outputs, which are refused otherwise",
    )


def check(outputs: Sequence[Output], inputs: Sequence[Path], overwrite: bool) -> None:
    """Check that outputs can and may be written.

    Args:
        outputs: Outputs of the command.
        inputs: Its inputs, which are never written.
        overwrite: Whether existing outputs may be replaced.

    Raises:
        ExportError: An output cannot or must not be written.
    """
    places: List[Path] = []
    for output in outputs:
        own = output.path.absolute()
        place = own.parent.resolve() / own.name
        if place in places:
            raise ExportError(
                Message(
                    "{path} is given twice; each output needs a different name", path=output.path
                )
            )
        places.append(place)
        _check_apart(output.path, place, inputs)
        if os.path.lexists(str(place)):
            _check_replaceable(output, overwrite)
        else:
            _check_parent(output.path, place)


def check_survey_folders(data: Path, inputs: Sequence[Path]) -> None:
    """Check that a folder of surveys can take another one.

    Args:
        data: The folder.
        inputs: Inputs of the command, which are never written.

    Raises:
        ExportError: It cannot or must not be written.
    """
    inside = data.absolute().resolve() / "survey"
    for place in (inside, inside.parent):
        _check_apart(data, place, inputs)
    _check_parent(data, inside)


def _check_apart(path: Path, place: Path, inputs: Sequence[Path]) -> None:
    if place in [one.resolve() for one in inputs]:
        raise ExportError(
            Message("{path} is an input of this command; choose another output", path=path)
        )
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


def _check_replaceable(output: Output, overwrite: bool) -> None:
    path = output.path
    if path.is_dir() != bool(output.holds):
        raise ExportError(
            Message(
                "{path} is a {found}, but the output is a {needed}; choose another",
                path=path,
                found="folder" if path.is_dir() else "file",
                needed="folder" if output.holds else "file",
            )
        )
    names = [one.name for one in path.iterdir()] if output.holds else [path.name]
    if names and not overwrite:
        raise ExportError(
            Message(
                "{path} exists; replace it with --overwrite, or choose another place", path=path
            )
        )
    others = [one for one in names if not any(fnmatch(one, each) for each in output.holds)]
    if output.holds and others:
        raise ExportError(
            Message(
                "{path} contains other files (e.g. {name}), which would be deleted; choose another "
                "folder",
                path=path,
                name=min(others),
            )
        )


def _check_parent(path: Path, place: Path) -> None:
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
    """Write a figure as PNG, SVG or PDF, depending on the ending of the path.

    Raises:
        ExportError: The path has another ending.
        OSError: It cannot be written.
    """
    if path.suffix not in FORMATS:
        raise ExportError(wrong_ending(path, FORMATS))
    figure.savefig(str(path), dpi=RESOLUTION_DPI)
