"""Exports of a survey: reports and lists of the analysis, and the whole as a ZIP file."""

from __future__ import annotations

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
from gpr20_imaging.faults import STICK, ImagingError, StickError
from gpr20_imaging.low.stick_files import StickFolder, UsbVolumes
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.regular_files import add_folder
from gpr20_survey.results.answers import ExportPart, Volume

FOLDER = "GPR20"
MARGIN_BYTES = 1 << 20
# Of a ZIP file the fastest: traces are text of half the size then, and sticks are slow.
LEVEL = 1
SIMULATED_MARK = "_SIMULATED"
GONE = (errno.ENOENT, errno.EIO, errno.ENODEV, errno.ENXIO, errno.ESTALE, errno.EROFS)
WORDS = {
    ExportPart.REPORT_HTML: Message("report as HTML"),
    ExportPart.CANDIDATES_CSV: Message("candidates as CSV"),
    ExportPart.CANDIDATES_GEOJSON: Message("candidates as GeoJSON"),
    ExportPart.SURVEY_ZIP: Message("whole survey as ZIP"),
}
"""What people call them."""


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
    kinds: Tuple[ExportPart, ...]
    permittivity: Optional[float]
    language: str
    volume: str

    def name(self, kind: ExportPart) -> str:
        """Return the name of a file on the stick."""
        mark = SIMULATED_MARK if self.simulated else ""
        return f"{self.folder.name}{mark}_{kind.value.replace('-', '.')}"


class Exporter:
    """Writes files of a survey to a stick.

    Args:
        analysis: As `gpr20_imaging.mid.worker.Analysis`.
        volumes: The sticks.
        report: Called with what is being done.
    """

    def __init__(
        self, analysis: Any, volumes: UsbVolumes, report: Callable[[Message], None]
    ) -> None:
        self._analysis, self._volumes, self._report = analysis, volumes, report

    def export(self, request: ExportRequest) -> List[str]:
        """Write the files; return their names when all of them are on the stick.

        Raises:
            ImagingError: Something is missing, or the stick is full or was removed. No file has
                its name unless it is whole.
        """
        volume = self._volumes.find(request.volume)
        if not volume.writable:
            raise StickError(
                Message(
                    "the USB stick {name} is write-protected; remove the protection",
                    name=volume.name,
                ),
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

    def _made(self, kind: ExportPart, request: ExportRequest, folder: Path) -> Optional[Path]:
        """Return the file that the analysis has written; None if the kind needs none."""
        if kind is ExportPart.SURVEY_ZIP:
            return None
        self._report(Message("creating {what}", what=WORDS[kind]))
        path = folder / request.name(kind)
        is_report = kind is ExportPart.REPORT_HTML
        write = self._analysis.write_report if is_report else self._analysis.write_candidates
        write(request.folder, path, request.permittivity, request.language)
        return path

    def _put(
        self,
        files: Sequence[Tuple[ExportPart, Optional[Path]]],
        request: ExportRequest,
        volume: Volume,
    ) -> List[str]:
        needed = sum(path.stat().st_size for _, path in files if path is not None) + MARGIN_BYTES
        if volume.free_bytes < needed:
            raise StickError(
                Message(
                    "the USB stick {name} has {free_mb:.0f} MB free, but {needed_mb:.0f} MB are "
                    "needed; make space or use another one",
                    name=volume.name,
                    free_mb=volume.free_bytes / 1e6,
                    needed_mb=needed / 1e6,
                ),
            )
        with StickFolder(volume, FOLDER) as folder:
            folder.remove_unfinished()
            for kind, path in files:
                self._report(Message("copying {what} to the USB stick", what=WORDS[kind]))
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


def _refusal(volume: Volume, error: OSError) -> StickError:
    known = {"name": volume.name, "details": error}
    if error.errno == errno.ENOSPC:
        message = Message(
            "the USB stick {name} is full; nothing unfinished was left on it. Make space or use "
            "another one.",
            **known,
        )
    elif error.errno == errno.EFBIG:
        message = Message(
            "the file is too large for the file system of the USB stick {name}; format it as "
            "exFAT, which deletes what is on it",
            **known,
        )
    elif error.errno in GONE:
        message = Message(
            "the USB stick {name} was removed, or failed, before everything was written", **known
        )
    else:
        reason = os_reason(error)
        message = Message(
            "the USB stick {name} could not be written: {reason}", **known, reason=reason
        )
    return StickError(message.reporting_only(STICK))


def _write_zip(folder: Path, target: Any) -> None:
    try:
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
            for _ in add_folder(archive, folder):
                pass
    except ProcessingError as error:
        raise ImagingError(error.message) from error
