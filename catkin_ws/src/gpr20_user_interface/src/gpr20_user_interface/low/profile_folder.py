"""A folder of small YAML files."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any, List, Mapping

import yaml

from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_user_interface.errors import ProfileError

SUFFIX = ".yaml"
# A profile has some hundred bytes; what is far larger is something else.
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
            # The window would wait for a pipe for ever.
            return sorted(path.stem for path in found if path.is_file())
        except OSError as error:
            raise ProfileError(
                f"the profiles in {self._folder} cannot be listed: {error}"
            ) from error

    def read(self, name: str) -> Any:
        """Return what a file holds.

        Raises:
            ProfileError: It is missing, too large or not YAML.
        """
        path = self._path(name)
        try:
            return read_yaml(path, MAX_BYTES)
        except (OSError, YamlFileError) as error:
            raise ProfileError(
                f"the profile {path} cannot be read: {error}; save it again"
            ) from error

    def write(self, name: str, values: Mapping[str, Any]) -> None:
        """Write a file; a power cut leaves the former one or the new one.

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
                f"the profile {self._path(name)} cannot be written: {error}; free space on the "
                "disk, or let the parameter `profiles` name another folder"
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
                f"the profile {self._path(name)} cannot be deleted: {error}"
            ) from error

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}{SUFFIX}"
