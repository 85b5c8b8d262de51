"""Exports to a USB stick."""

from __future__ import annotations

import errno
import re
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, List, Optional, Sequence, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import CancelledError, ExportFailedError, ImagingError
from gpr20_imaging.low import stick_files
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.low.stick_files import StickFolder
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.export_kind import ExportKind
from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.folder_zip import add_folder
from gpr20_survey.folder.survey_folder import FOLDER_NAME
from gpr20_survey.results.volume import Volume

FOLDER = "GPR20"
MARGIN_BYTES = 1 << 20
# Of a ZIP file the fastest: traces are text of half the size then, and sticks are slow.
LEVEL = 1
SIMULATED_MARK = "_SIMULATED"
_ENDINGS = "|".join(re.escape(kind.ending) for kind in ExportKind)
_NAME = re.compile(f"{FOLDER_NAME.pattern}({SIMULATED_MARK})?_({_ENDINGS})")
GONE = (errno.ENOENT, errno.EIO, errno.ENODEV, errno.ENXIO, errno.ESTALE, errno.EROFS)


def is_export(name: str) -> bool:
    """Return whether a name is one that an `ExportRequest` gives."""
    return _NAME.fullmatch(name) is not None


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
        analysis: The analysis.
        volumes: The sticks.
        report: Called with what is being done.
    """

    def __init__(
        self, analysis: AnalysisProcess, volumes: UsbVolumes, report: Callable[[Message], None]
    ) -> None:
        self._analysis = analysis
        self._volumes = volumes
        self._report = report

    def export(self, request: ExportRequest, cancellation: Cancellation) -> List[str]:
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
            files = [(kind, self._made(kind, request, Path(made), cancellation))
                     for kind in request.kinds]  # fmt: skip
            try:
                return self._put(files, request, volume, cancellation)
            except OSError as error:
                if isinstance(error, ImagingError):
                    raise
                raise self._refusal(volume, error) from error

    def make(self, request: ExportRequest, cancellation: Cancellation) -> Tuple[str, bytes]:
        """Return the name and the content of the only file of a request, without a stick.

        Raises:
            ImagingError: It cannot be made, or the analysis makes no such file.
        """
        with tempfile.TemporaryDirectory(prefix="gpr20_export_") as made:
            paths = [self._made(kind, request, Path(made), cancellation) for kind in request.kinds]
            if len(paths) == 1 and paths[0] is not None:
                return paths[0].name, paths[0].read_bytes()
        raise ImagingError(
            Message("without a USB stick only one report or list of candidates can be made"),
            fault=NOT_ALLOWED,
        )

    def _made(
        self, kind: ExportKind, request: ExportRequest, folder: Path, cancellation: Cancellation
    ) -> Optional[Path]:
        """Return the file that the analysis has written; None if the kind needs none."""
        if not kind.analysis:
            return None
        self._report(Message("creating {what}", what=kind.message))
        path = folder / request.name(kind)
        source = (request.folder, path, request.permittivity, request.language)
        try:
            self._analysis.write(kind.analysis, *source, cancellation)
        except CancelledError:
            raise
        except ImagingError as error:
            raise ImagingError(
                Message(
                    "{what} could not be created: {reason}",
                    what=kind.message,
                    reason=error.message,
                )
            ) from error
        return path

    def _put(
        self,
        files: Sequence[Tuple[ExportKind, Optional[Path]]],
        request: ExportRequest,
        volume: Volume,
        cancellation: Cancellation,
    ) -> List[str]:
        needed = sum(path.stat().st_size for _, path in files if path is not None) + MARGIN_BYTES
        if volume.free_bytes < needed:
            raise ExportFailedError(
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
            folder.remove_unfinished(is_export)
            for kind, path in files:
                self._report(Message("copying {what} to the USB stick", what=kind.message))
                with folder.new_file(request.name(kind), cancellation) as target:
                    if path is None:
                        _write_zip(request.folder, target)
                    else:
                        stick_files.copy_file(path, target)
                    # Before it gets its name: this may be a folder of the disk by now.
                    self._volumes.check_present(volume)
            self._report(Message("waiting until the USB stick has stored everything"))
            folder.sync()
            self._report(Message("reading what the USB stick has stored"))
            folder.check_written(cancellation)
            folder.check_in_place()
            self._volumes.check_present(volume)
        return [f"{FOLDER}/{request.name(kind)}" for kind, _ in files]

    def _refusal(self, volume: Volume, error: OSError) -> ExportFailedError:
        if error.errno == errno.ENOSPC:
            return ExportFailedError(
                Message(
                    "the USB stick {name} is full; nothing unfinished was left on it. Make space "
                    "or use another one.",
                    name=volume.name,
                    details=error,
                ),
                fault=faults.STICK,
            )
        if error.errno == errno.EFBIG:
            return ExportFailedError(
                Message(
                    "the file is too large for the file system of the USB stick {name}; format it "
                    "as exFAT, which deletes what is on it",
                    name=volume.name,
                    details=error,
                ),
                fault=faults.STICK,
            )
        if error.errno in GONE:
            return ExportFailedError(
                Message(
                    "the USB stick {name} was removed, or failed, before everything was written",
                    name=volume.name,
                    details=error,
                )
            )
        return ExportFailedError(
            Message(
                "the USB stick {name} could not be written: {reason}",
                name=volume.name,
                reason=os_reason(error),
            ).reporting_only(faults.STICK)
        )


def _write_zip(folder: Path, target: Any) -> None:
    try:
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
            for _ in add_folder(archive, folder):
                pass
    except ProcessingError as error:
        raise ImagingError(error.message) from error
