"""The formats of other programs that installed packages import."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Callable, Optional, Tuple, Union

import numpy as np
import xarray as xr

from gpr20_analysis import errors
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.sentences import FAULTS, with_doubts
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.plan.recorded_plan import IMPORTED, TIMES_KNOWN

OUTPUT = "survey.nc"
"""In the command that a refusal names."""


@dataclass(frozen=True)
class Band:
    """The frequencies at which the spectra of simulated A-scans are taken [Hz]."""

    start_hz: float = 600e6
    stop_hz: float = 6e9
    points: int = 501

    @property
    def frequency_hz(self) -> np.ndarray:
        """The frequencies [Hz]."""
        return np.linspace(self.start_hz, self.stop_hz, self.points)


@dataclass(frozen=True)
class ImportOptions:
    """What a user can say about the files of another program.

    Attributes:
        band: Frequencies for the spectra of a simulation; None: those of the robot.
        height_m: Antenna height [m].
        source: Source signal of a simulation, as after `--source`.
        time_zero_s: Time in the record at which the pulse leaves the antennas, counted from the
            first sample [s].
        separation_m: Distance between the antennas [m].
        spacing_m: Distance between traces along a line, for files that record none [m].
        channel: Number of the channel, from 1.
        interval_s: Time between samples, for files whose unit of time is not known [s].
    """

    band: Optional[Band] = None
    height_m: Optional[float] = None
    source: Optional[str] = None
    time_zero_s: Optional[float] = None
    separation_m: Optional[float] = None
    spacing_m: Optional[float] = None
    channel: Optional[int] = None
    interval_s: Optional[float] = None


@dataclass(frozen=True)
class ImportFormat:
    """A format of another program.

    Attributes:
        read: Returns the Dataset of a file or folder.
        whole: Returns what must be imported if a path has this format: the path, or the folder of
            a file that is one sample of many; None if the path has another format.
        takes: The options that it uses; others are refused.
    """

    read: Callable[[Path, ImportOptions, Progress], xr.Dataset]
    whole: Callable[[Path], Optional[Path]]
    takes: Tuple[str, ...] = ("band", "height_m", "source")

    def check(self, name: str, options: ImportOptions) -> None:
        """Refuse options that the format of this name cannot use.

        Raises:
            AnalysisError: There is one.
        """
        given = [one.name for one in fields(options) if getattr(options, one.name) is not None]
        unused = [_argument(one) for one in given if one not in self.takes]
        if unused:
            raise AnalysisError(
                Message(
                    "the format {format} cannot use {option}; leave it out. It uses {options}",
                    format=name,
                    option=unused[0],
                    options=", ".join(map(_argument, self.takes)) or "-",
                )
            )


def _argument(option: str) -> str:
    """Return the argument of the command line of an option, which has no unit in its name."""
    return "--" + re.sub("_(m|s)$", "", option).replace("_", "-")


IMPORTS = ExtensionPoint(
    "gpr20_analysis.imports",
    Message("the format"),
    fault=errors.STEPS,
    wings=dict.fromkeys(
        (
            *("group-csv", "merged-hdf5", "gprmax", "original-json", "arrays"),
            *("dt1", "dzt", "rd3", "segy", "touchstone"),
        ),
        "gpr20_foreign_formats",
    ),
    kind=ImportFormat,
)
"""By this, other packages add formats that can be imported."""


def import_survey(
    path: Union[str, Path], form: str, progress: Progress = no_progress, **options: Any
) -> xr.Dataset:
    """Read measurements and simulations of other programs as the Dataset of a survey.

    Args:
        path: File, or folder of files.
        form: Name of a format of an installed package.
        progress: Shows the progress.
        **options: Those of `ImportOptions`, such as height_m.

    Raises:
        AnalysisError: It does not have this format, is damaged, or differs from what is said beside
            it; or the format cannot use an option.
        MissingLibraryError: The package of the format, or a library, is not installed.
    """
    # Also of `.` and of the file of a folder the name is told.
    chosen, place = ImportOptions(**options), Path(path).expanduser().absolute()
    refuse_device(place)
    importer: ImportFormat = IMPORTS.find(form)
    importer.check(form, chosen)
    found = importer.read(place, chosen, progress)
    # A Dataset has no times in place of those that are not known.
    entry = {"source": place.name, "format": form, TIMES_KNOWN: True}
    damaged = len(found.attrs.get(FAULTS, ()))
    return with_doubts(found, *survey_doubts({IMPORTED: entry}, (), damaged))


def refuse_device(path: Path) -> None:
    """Refuse pipes, devices and the like, which some readers would wait for.

    Raises:
        AnalysisError: There is something, but neither a file nor a folder.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise AnalysisError(
            Message("{path} is neither a file nor a folder, so it is not a survey", path=path),
            fault=errors.INPUT,
        )


def _typed(name: str) -> str:
    """Return how a person types a name into a shell, also one that a terminal cannot show."""
    plain = name.replace("\\", r"\\").replace("'", r"\'")
    return shlex.quote(name) if printable(name) == name else f"$'{printable(plain)}'"


def refuse_importable(path: Path) -> None:
    """Refuse files of the formats of installed packages with the command that imports them.

    Raises:
        AnalysisError: It is such a file or folder.
    """
    for form in IMPORTS.added():
        whole = IMPORTS.find(form).whole(path)
        if whole is not None:
            command = f"gpr20 import {_typed(str(whole))} {OUTPUT} --format {form}"
            raise AnalysisError(
                Message(
                    "{path} has the format {format}; import it first: {command}",
                    path=path,
                    format=form,
                    command=command,
                ),
                fault=errors.INPUT,
            )
