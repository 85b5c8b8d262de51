"""Exports of a survey: reports and lists of the analysis, and the whole as a ZIP file."""

from __future__ import annotations

import enum
import errno
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfileobj
from typing import Any, Callable, List, Optional, Sequence, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.stick_files import StickFolder
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.folder_zip import add_folder
from gpr20_survey.results.volume import Volume

FOLDER = "GPR20"
MARGIN_BYTES = 1 << 20
# Of a ZIP file the fastest: traces are text of half the size then, and sticks are slow.
LEVEL = 1
SIMULATED_MARK = "_SIMULATED"
GONE = (errno.ENOENT, errno.EIO, errno.ENODEV, errno.ENXIO, errno.ESTALE, errno.EROFS)


class ExportKind(enum.Enum):
    """One file of an export.

    Attributes:
        ending: End of the file's name.
        message: What people call it.
    """

    REPORT_HTML = ("report-html", "report.html", Message("report as HTML"))
    CANDIDATES_CSV = ("candidates-csv", "candidates.csv", Message("candidates as CSV"))
    CANDIDATES_GEOJSON = (
        "candidates-geojson",
        "candidates.geojson",
        Message("candidates as GeoJSON"),
    )
    SURVEY_ZIP = ("survey-zip", "survey.zip", Message("whole survey as ZIP"))

    def __init__(self, label: str, ending: str, message: Message) -> None:
        self.label, self.ending, self.message = label, ending, message

    @classmethod
    def of(cls, label: str) -> ExportKind:
        """Return the kind that the messages of ROS call so.

        Raises:
            ImagingError: There is none.
        """
        for one in cls:
            if one.label == label:
                return one
        raise ImagingError(
            Message(
                "{name} cannot be exported; allowed: {kinds}",
                name=repr(label[:64]),
                kinds=", ".join(one.label for one in cls),
            ),
            fault=NOT_ALLOWED,
        )


@dataclass(frozen=True)
class ExportRequest:
    """What to export.

    Attributes:
        folder: The survey's folder.
        simulated: Whether the survey shows no real ground.
        kinds: The files.
        permittivity: Relative permittivity of the ground; None: what the survey says.
        language: Code of the language of reports.
        volume: Path of the stick.
    """

    folder: Path
    simulated: bool
    kinds: Tuple[ExportKind, ...]
    permittivity: Optional[float]
    language: str
    volume: str

    def name(self, kind: ExportKind) -> str:
        """Return the name of a file on the stick."""
        mark = SIMULATED_MARK if self.simulated else ""
        return f"{self.folder.name}{mark}_{kind.ending}"


class Exporter:
    """Writes files of a survey to a stick.

    Args:
        analysis: As `gpr20_imaging.low.analysis_worker.Analysis`.
        volumes: The sticks.
        report: Called with what is being done.
    """

    def __init__(
        self, analysis: Any, volumes: UsbVolumes, report: Callable[[Message], None]
    ) -> None:
        self._analysis = analysis
        self._volumes = volumes
        self._report = report

    def export(self, request: ExportRequest) -> List[str]:
        """Write the files; return their names when all of them are on the stick.

        Raises:
            ImagingError: Something is missing, or the stick is full or was removed. No file has
                its name unless it is whole.
        """
        volume = self._volumes.find(request.volume)
        if not volume.writable:
            raise ImagingError(
                Message(
                    "the USB stick {name} is write-protected; remove the protection",
                    name=volume.name,
                ),
                fault=faults.STICK,
            )
        with tempfile.TemporaryDirectory(prefix="gpr20_export_") as made:
            # Before the stick is touched: it may be refused, and takes longest.
            files = [(kind, self._made(kind, request, Path(made))) for kind in request.kinds]
            try:
                return self._put(files, request, volume)
            except OSError as error:
                raise _refusal(volume, error) from error

    def make(self, request: ExportRequest) -> Tuple[str, bytes]:
        """Return the name and the content of the only file of a request, without a stick.

        Raises:
            ImagingError: It cannot be made, or the analysis makes no such file.
        """
        with tempfile.TemporaryDirectory(prefix="gpr20_export_") as made:
            paths = [self._made(kind, request, Path(made)) for kind in request.kinds]
            if len(paths) == 1 and paths[0] is not None:
                return paths[0].name, paths[0].read_bytes()
        raise ImagingError(
            Message("without a USB stick only one report or list of candidates can be made"),
            fault=NOT_ALLOWED,
        )

    def _made(self, kind: ExportKind, request: ExportRequest, folder: Path) -> Optional[Path]:
        """Return the file that the analysis has written; None if the kind needs none."""
        if kind is ExportKind.SURVEY_ZIP:
            return None
        self._report(Message("creating {what}", what=kind.message))
        path = folder / request.name(kind)
        is_report = kind is ExportKind.REPORT_HTML
        write = self._analysis.write_report if is_report else self._analysis.write_candidates
        write(request.folder, path, request.permittivity, request.language)
        return path

    def _put(
        self,
        files: Sequence[Tuple[ExportKind, Optional[Path]]],
        request: ExportRequest,
        volume: Volume,
    ) -> List[str]:
        needed = sum(path.stat().st_size for _, path in files if path is not None) + MARGIN_BYTES
        if volume.free_bytes < needed:
            raise ImagingError(
                Message(
                    "the USB stick {name} has {free_mb:.0f} MB free, but {needed_mb:.0f} MB are "
                    "needed; make space or use another one",
                    name=volume.name,
                    free_mb=volume.free_bytes / 1e6,
                    needed_mb=needed / 1e6,
                ),
                fault=faults.STICK,
            )
        with StickFolder(volume, FOLDER) as folder:
            folder.remove_unfinished()
            for kind, path in files:
                self._report(Message("copying {what} to the USB stick", what=kind.message))
                with folder.new_file(request.name(kind)) as target:
                    if path is None:
                        _write_zip(request.folder, target)
                    else:
                        with path.open("rb") as stream:
                            copyfileobj(stream, target)
                    # Before it gets its name: the stick may be gone by now.
                    folder.check_in_place()
            self._report(Message("waiting until the USB stick has stored everything"))
            folder.sync()
            self._report(Message("reading what the USB stick has stored"))
            folder.check_written()
            folder.check_in_place()
        return [f"{FOLDER}/{request.name(kind)}" for kind, _ in files]


def _refusal(volume: Volume, error: OSError) -> ImagingError:
    if error.errno == errno.ENOSPC:
        message = Message(
            "the USB stick {name} is full; nothing unfinished was left on it. Make space or use "
            "another one.",
            name=volume.name,
            details=error,
        )
    elif error.errno == errno.EFBIG:
        message = Message(
            "the file is too large for the file system of the USB stick {name}; format it as "
            "exFAT, which deletes what is on it",
            name=volume.name,
            details=error,
        )
    elif error.errno in GONE:
        message = Message(
            "the USB stick {name} was removed, or failed, before everything was written",
            name=volume.name,
            details=error,
        )
    else:
        message = Message(
            "the USB stick {name} could not be written: {reason}",
            name=volume.name,
            reason=os_reason(error),
        )
    return ImagingError(message.reporting_only(faults.STICK))


def _write_zip(folder: Path, target: Any) -> None:
    try:
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
            for _ in add_folder(archive, folder):
                pass
    except ProcessingError as error:
        raise ImagingError(error.message) from error
