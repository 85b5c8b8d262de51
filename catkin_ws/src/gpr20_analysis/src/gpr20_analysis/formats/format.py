"""What a format of files is, and the formats that installed packages add."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import AnalysisError, ExportError
from gpr20_analysis.progress import Progress
from gpr20_common.message import Message

Writer = Callable[[xr.Dataset, Path, Progress], Message]
RecordingExport = Tuple[Message, Mapping[str, Any]]
WING = "gpr20_foreign_formats"


@dataclass(frozen=True)
class ExportFormat:
    """A format that a survey can be written in.

    Attributes:
        write: Writes a survey to a new path, and returns what was written.
        ending: Ending of the file's name; empty: a folder with one file per sample.
        holds: Patterns of the file names in the folder.
        has_own_checksum: Its files contain their checksum, so that none is needed beside them.
        over_time: It can hold A-scans over time.
        of_recording: Writes the recording of a survey in place of its Dataset; returns what was
            written and, as attributes of a Dataset, what is missing, damaged or doubted.
        in_survey: Writes it into the survey's folder.
    """

    write: Writer
    ending: str = ""
    holds: Tuple[str, ...] = ()
    has_own_checksum: bool = False
    over_time: bool = False
    of_recording: Optional[Callable[[Path, Path, Progress], RecordingExport]] = None
    in_survey: Optional[Callable[[Path], RecordingExport]] = None


def files_of(write: Callable[[xr.Dataset, Path, Progress], int]) -> Writer:
    """Return the writer of a folder, from a function that returns the number of files."""
    return lambda survey, path, progress: Message(
        "{count} files", count=write(survey, path, progress)
    )


def only_recordings(form: str) -> Writer:
    """Return what a format refuses a Dataset with that holds the messages of a recording."""

    def refuse(_survey: xr.Dataset, _path: Path, _progress: Progress) -> Message:
        raise ExportError(
            Message(
                "the format {format} holds the messages of a recording, which a Dataset does not "
                "have; use `gpr20 export` with the survey's folder or recording",
                format=form,
            ),
            fault=faults.INPUT,
        )

    return refuse


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


ARGUMENTS = {
    "band": "--band",
    "height_m": "--height",
    "source": "--source",
    "time_zero_s": "--time-zero",
    "separation_m": "--separation",
    "spacing_m": "--spacing",
    "channel": "--channel",
    "interval_s": "--interval",
}
"""The options on the command line."""


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
        given = (one.name for one in fields(options) if getattr(options, one.name) is not None)
        unused = [ARGUMENTS[one] for one in given if one not in self.takes]
        if unused:
            raise AnalysisError(
                Message(
                    "the format {format} cannot use {option}; leave it out. It uses {options}",
                    format=name,
                    option=unused[0],
                    options=", ".join(ARGUMENTS[one] for one in self.takes) or "-",
                )
            )


IMPORTS = ExtensionPoint(
    "gpr20_analysis.imports",
    Message("the format"),
    fault=faults.STEPS,
    wings=dict.fromkeys(
        (
            *("group-csv", "merged-hdf5", "gprmax", "original-json", "arrays"),
            *("dt1", "dzt", "rd3", "segy", "touchstone"),
        ),
        WING,
    ),
    kind=ImportFormat,
)
"""By this, other packages add formats that can be imported."""
