"""The folder of the surveys: whether it is the one that was used before, on the right disk."""

from __future__ import annotations

import contextlib
import errno
import os
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import ContextManager, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import ProcessingError, SurveyRefusedError, storing
from gpr20_survey.files.access import Readers
from gpr20_survey.files.data_marker import (
    MARKER_FILE,
    DamagedRecordError,
    FolderMemory,
    Marker,
    read_marker,
    write_marker,
)
from gpr20_survey.files.durable_files import ensure_folders
from gpr20_survey.files.file_system import (
    IN_MEMORY,
    ROOT,
    FileSystem,
    check_can_store,
    existing_folder,
    file_system_of,
)
from gpr20_survey.trace.utc_time import iso_text

# A file system that cannot hold surveys is tried again after this time [s].
RETRY_S = 10.0


@dataclass(frozen=True)
class DataFolderUse:
    """How a data folder is used."""

    path: Path
    """The folder, absolute."""
    state: Path
    """Folder of what this computer remembers."""
    own_disk: bool = False
    """Whether it must be on a disk of its own."""
    mode: int = Readers.GROUP.folder_mode
    """Of the folder, if it is made."""


@dataclass(frozen=True)
class KnownFolder:
    """A data folder with which nothing is wrong."""

    identity: str
    """As its marker has it; empty before the first use."""
    remembered: bool
    """Whether it was used before here."""


@dataclass(frozen=True)
class _Tried:
    """When a file system was tried, and what it lacks."""

    device: int
    at_s: float
    failure: Optional[Message]


class DataFolder:
    """Makes and marks the folder at its first use, and from then on accepts no other.

    What is remembered is outside of the folder, by its path. A path that was never used gets its
    marker when it is checked; where a folder was used before, one without its marker is refused,
    and nothing is made in its place.
    """

    def __init__(self, use: DataFolderUse, clock: Clock) -> None:
        """Look at nothing yet.

        Args:
            use: Which folder, and how it is used.
            clock: Tells when to try the file system again, and the date of a marker.
        """
        self._use = use
        self._path = use.path
        self._clock = clock
        self._memory = FolderMemory(use.state)
        self._tried: Optional[_Tried] = None

    def identify(self) -> KnownFolder:
        """Return what the folder is; write nothing.

        Raises:
            SurveyRefusedError: It is not the one that was used before, or on the wrong disk.
            StorageFailedError: It cannot be read, or not be written to.
        """
        return self._look()[1]

    def check(self) -> None:
        """Make sure that surveys may be stored in the folder; mark it at its first use.

        Raises:
            SurveyRefusedError: It is not the one that was used before, or on a wrong disk.
            StorageFailedError: It cannot be made, read, or written to.
        """
        known = self.identify()
        self.check_file_system()
        if not known.identity:
            # Another program may use it first at this moment.
            with self._using(), contextlib.suppress(FileExistsError):
                self._new_marker()
            known = self.identify()
        if not known.remembered:
            with self._using():
                self._memory.remember(self._path, known.identity)

    def accept(self) -> str:
        """Make the folder at this path the one that is used from now on; return its identity.

        Raises:
            SurveyRefusedError: It is on a wrong disk.
            StorageFailedError: It cannot be made, read, or written to.
        """
        with self._using():
            system = self._system()
        self.check_file_system()
        with self._using():
            try:
                marker = read_marker(self._path)
            except DamagedRecordError:
                marker = None
            if marker is None or system.is_other_than(marker.file_system):
                marker = self._new_marker(replace=True)
            self._memory.remember(self._path, marker.identity)
        return marker.identity

    def problem(self) -> Optional[Message]:
        """Return why surveys cannot be stored, with its fault; None if they can.

        It is cheap: the file system is tried once, and again only if that failed or if it is
        another one.
        """
        try:
            system, _ = self._look()
            tried = self._tried
            if (
                tried is not None
                and tried.device == system.device
                and (tried.failure is None or self._clock.now_s() - tried.at_s < RETRY_S)
            ):
                return tried.failure
            self.check_file_system()
        except ProcessingError as error:
            return error.message
        return None

    def check_file_system(self) -> None:
        """Make sure that the file system can hold surveys; leave nothing behind.

        Raises:
            SurveyRefusedError: It lacks something.
            StorageFailedError: It cannot be written to.
        """
        failure = None
        with self._using():
            existing = existing_folder(self._path)
            device = existing.stat().st_dev
        try:
            with self._using():
                check_can_store(existing)
        except ProcessingError as error:
            failure = error.message
            raise
        finally:
            self._tried = _Tried(device, self._clock.now_s(), failure)

    def _look(self) -> Tuple[FileSystem, KnownFolder]:
        with self._using():
            system = self._system()
            known = self._known(system)
            if system.read_only:
                raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        return system, known

    def _system(self) -> FileSystem:
        system = file_system_of(existing_folder(self._path))
        if self._use.own_disk and (
            system.kind in IN_MEMORY or system.is_same(file_system_of(ROOT))
        ):
            raise SurveyRefusedError(
                Message(
                    "the data folder {path} is not on a disk of its own, but on the file system of "
                    "{mount_point}",
                    path=printable(self._path),
                    mount_point=printable(system.mount_point),
                    details="storage.yaml: data_disk",
                ),
                fault=faults.NO_DATA_DISK,
            )
        return system

    def _known(self, system: FileSystem) -> KnownFolder:
        expected: Optional[str] = "?"
        try:
            expected = self._memory.identity_at(self._path)
            marker = read_marker(self._path)
        except DamagedRecordError as error:
            wrong = Message("{file} is damaged", file=str(error))
        else:
            if marker is None and expected is None:
                return KnownFolder("", remembered=False)
            if marker is None and not self._path.is_dir():
                wrong = Message("it is gone")
            elif marker is None:
                wrong = Message("its marker {file} is missing", file=MARKER_FILE)
            elif expected not in (None, marker.identity):
                wrong = Message("its identity is {identity}", identity=printable(marker.identity))
            elif system.is_other_than(marker.file_system):
                expected = marker.identity
                wrong = Message(
                    "it is a copy on the file system {found}; the original is on {expected}",
                    found=system.identity or system.kind,
                    expected=printable(marker.file_system),
                )
            else:
                return KnownFolder(marker.identity, remembered=expected is not None)
        raise SurveyRefusedError(
            Message(
                "{path} is not the data folder that was used before (identity {expected}): {found}",
                path=printable(self._path),
                expected=expected and printable(expected),
                found=wrong,
            ),
            fault=faults.OTHER_DATA_FOLDER,
        )

    def _new_marker(self, replace: bool = False) -> Marker:
        ensure_folders(self._path, self._use.mode)
        made = iso_text(self._clock.time_of_day_us())
        marker = Marker(str(uuid.uuid4()), file_system_of(self._path).identity, made)
        write_marker(self._path, marker, replace)
        return marker

    def _using(self) -> ContextManager[None]:
        failure = Message("the data folder {path} cannot be used", path=printable(self._path))
        return storing(failure, self._path)
