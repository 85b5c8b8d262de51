"""The outputs of a subcommand: checked before any work, never replaced unless that is asked for."""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, List, Sequence

from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats.dataset_files import NETCDF, ZARR, is_dataset
from gpr20_survey.folder import survey_folder

SURVEY_PARTS = (survey_folder.SURVEY_FILE, survey_folder.TRACES_FOLDER)


@dataclass(frozen=True)
class Output:
    """One file or folder that a subcommand writes.

    Attributes:
        path: Where.
        holds: Patterns of the names in a folder; only a folder that holds nothing else is replaced.
        marked_by: Name in a folder that shows that all of it is such an output.
    """

    path: Path
    holds: Sequence[str] = ()
    marked_by: str = ""

    @property
    def is_folder(self) -> bool:
        """Whether a folder is written, not a file."""
        return bool(self.holds or self.marked_by)

    def may_delete(self, names: Sequence[str]) -> bool:
        """Say whether a folder of these names is such an output, and nothing else."""
        if self.marked_by:
            return self.marked_by in names
        return all(any(fnmatch(name, pattern) for pattern in self.holds) for name in names)


def dataset_output(path: Path) -> Output:
    """Return the output of a Dataset: a file .nc or a folder .zarr.

    Raises:
        ExportError: The name ends in something else.
    """
    if not is_dataset(path):
        raise ExportError(f"{path} must end in {NETCDF} or {ZARR}")
    return Output(path, marked_by=".zgroup" if path.suffix == ZARR else "")


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Declare the option without which nothing is replaced."""
    parser.add_argument(
        "--overwrite", action="store_true", help="replace outputs that exist; else they are refused"
    )


def check(outputs: Sequence[Output], inputs: Sequence[Path], overwrite: bool) -> None:
    """Check that outputs can be written and may be.

    Args:
        outputs: What will be written.
        inputs: What is read, which is never written.
        overwrite: What exists may be replaced.

    Raises:
        ExportError: It names the output, why it is refused, and what to do.
    """
    places: List[Path] = []
    for output in outputs:
        own = output.path.absolute()
        place = own.parent.resolve() / own.name
        if place in places:
            raise ExportError(f"{output.path} is named twice; give each output a name of its own")
        places.append(place)
        _check_apart(output.path, place, inputs)
        if os.path.lexists(str(place)):
            _check_replaceable(output, overwrite)
        else:
            _check_parent(output.path, place)


def _check_apart(path: Path, place: Path, inputs: Sequence[Path]) -> None:
    if place in [one.resolve() for one in inputs]:
        raise ExportError(f"{path} is read by this very command; name another output")
    for folder in place.parents:
        if all((folder / name).exists() for name in SURVEY_PARTS):
            raise ExportError(
                f"{path} lies in the folder of a survey, {folder}, which holds what was measured "
                "and nothing else; name another place"
            )


def _check_replaceable(output: Output, overwrite: bool) -> None:
    path = output.path
    if path.is_dir() != output.is_folder:
        wanted, there = ("folder", "file") if output.is_folder else ("file", "folder")
        raise ExportError(f"{path} is a {there}, but a {wanted} is to be written; name another one")
    names = [one.name for one in path.iterdir()] if output.is_folder else []
    if output.is_folder and not names:
        return
    if not overwrite:
        raise ExportError(f"{path} exists; --overwrite replaces it, or name another place")
    if output.is_folder and not output.may_delete(names):
        raise ExportError(
            f"{path} holds more than such an output (e.g. {min(names)}), which would be deleted; "
            "name another folder"
        )


def _check_parent(path: Path, place: Path) -> None:
    above = next(one for one in place.parents if one.exists())
    if not above.is_dir():
        raise ExportError(f"{path} cannot be written: {above} is no folder")
    if not os.access(str(above), os.W_OK | os.X_OK):
        raise ExportError(f"{path} cannot be written: {above} is read-only; name another place")


if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")
RESOLUTION_DPI = 300


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, SVG or PDF, by the name's ending.

    Raises:
        ExportError: The name ends in something else.
        OSError: It cannot be written.
    """
    if path.suffix not in FORMATS:
        raise ExportError(f"{path.name} must end in {', '.join(FORMATS)}")
    figure.savefig(str(path), dpi=RESOLUTION_DPI)
