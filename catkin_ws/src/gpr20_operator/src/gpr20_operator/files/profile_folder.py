"""A folder of small YAML files."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any, List, Mapping

import yaml

from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_operator import faults
from gpr20_operator.errors import ProfileError

SUFFIX = ".yaml"
# A profile has some hundred bytes; a far larger file is something else.
MAX_BYTES = 65536


class ProfileFolder:
    """Reads and writes the files; the names must have been checked."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def names(self) -> List[str]:
        """Return the names of the files, sorted; none if there is no folder yet.

        Raises:
            ProfileError: The folder cannot be read.
        """
        try:
            found = self._folder.glob(f"*{SUFFIX}")
            # Reading a pipe would block the window.
            return sorted(path.stem for path in found if path.is_file())
        except OSError as error:
            raise ProfileError(
                Message(
                    "the profiles in {folder} cannot be listed: {reason}",
                    folder=self._folder,
                    reason=os_reason(error),
                ),
                fault=faults.PROFILE_NOT_STORED,
            ) from error

    def read(self, name: str) -> Any:
        """Return what a file holds.

        Raises:
            ProfileError: It is missing, too large or not YAML.
        """
        path = self._path(name)
        try:
            return read_yaml(path, MAX_BYTES)
        except YamlFileError as error:
            raise _unreadable(path, error.message) from error
        except OSError as error:
            raise _unreadable(path, os_reason(error)) from error

    def write(self, name: str, values: Mapping[str, Any]) -> None:
        """Write a file; after a power cut it is the former one or the new one.

        Raises:
            ProfileError: It cannot be written.
        """
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=str(self._folder), suffix=".tmp")
            try:
                with os.fdopen(handle, "w", encoding="utf-8") as file:
                    yaml.safe_dump(dict(values), file, sort_keys=False)
                    file.flush()
                    os.fsync(file.fileno())
                os.replace(temporary, self._path(name))
            except BaseException:
                os.unlink(temporary)
                raise
        except OSError as error:
            raise ProfileError(
                Message(
                    "the profile {path} cannot be written: {reason}; free space on the disk, or "
                    "set another folder with the parameter `profiles`",
                    path=self._path(name),
                    reason=os_reason(error),
                ),
                fault=faults.PROFILE_NOT_STORED,
            ) from error

    def remove(self, name: str) -> None:
        """Delete a file.

        Raises:
            ProfileError: It cannot be deleted.
        """
        try:
            self._path(name).unlink()
        except OSError as error:
            raise ProfileError(
                Message(
                    "the profile {path} cannot be deleted: {reason}",
                    path=self._path(name),
                    reason=os_reason(error),
                ),
                fault=faults.PROFILE_NOT_STORED,
            ) from error

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}{SUFFIX}"


def _unreadable(path: Path, reason: Message) -> ProfileError:
    return ProfileError(
        Message(
            "the profile {path} cannot be read: {reason}; save it again", path=path, reason=reason
        )
    )
