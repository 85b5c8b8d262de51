"""Parameters of a survey that are stored under a name, each in a file of a folder."""

from __future__ import annotations

import re
from pathlib import Path
from typing import List

from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.faults import DISK_REFUSES, NOT_ALLOWED
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_operator import faults
from gpr20_operator.errors import ProfileError
from gpr20_operator.files.settings_file import MAX_BYTES, write_values
from gpr20_survey.plan.survey_parameters import SurveyParameters

SUFFIX = ".yaml"
MAX_NAME_LENGTH = 32
# Nothing with a meaning in a path: neither slash nor dot.
NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9 _-]{{0,{MAX_NAME_LENGTH - 1}}}")


def is_name(name: str) -> bool:
    """Return whether a text may become the name of a profile and of its file."""
    return NAME.fullmatch(name) is not None and name == name.strip()


class Profiles:
    """Parameters by name; checks every name and every value. Every method raises ProfileError.

    Args:
        folder: Of the files; it need not exist.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def names(self) -> List[str]:
        """Return the names of all profiles, sorted."""
        try:
            # Reading a pipe would block the window.
            found = [one.stem for one in self._folder.glob(f"*{SUFFIX}") if one.is_file()]
        except OSError as error:
            text = Message(
                "the profiles in {folder} cannot be listed: {reason}",
                folder=self._folder,
                reason=os_reason(error),
            )
            raise ProfileError(text, fault=DISK_REFUSES) from error
        return sorted(name for name in found if is_name(name))

    def load(self, name: str) -> SurveyParameters:
        """Return the parameters of a profile; whether this robot allows them is not checked."""
        path = self.path(name)
        try:
            return record_from(SurveyParameters, read_yaml(path, MAX_BYTES), path.name)
        except YamlFileError as error:
            raise _unreadable(path, error.message) from error
        except OSError as error:
            raise _unreadable(path, os_reason(error)) from error
        except InvalidValueError as error:
            text = Message("{reason}; save the profile again", reason=error.message)
            raise ProfileError(text.reporting_only(faults.SETTINGS_LOST)) from error

    def save(self, name: str, parameters: SurveyParameters) -> None:
        """Store parameters under a name, durably; they replace those that were there."""
        path = self.path(name)
        try:
            write_values(path, plain(parameters))
        except OSError as error:
            text = Message(
                "the profile {path} cannot be written: {reason}; free space on the disk, or "
                "set another folder with the parameter `profiles`",
                path=path,
                reason=os_reason(error),
            )
            raise ProfileError(text, fault=DISK_REFUSES) from error

    def remove(self, name: str) -> None:
        """Delete a profile."""
        path = self.path(name)
        try:
            path.unlink()
        except OSError as error:
            text = Message(
                "the profile {path} cannot be deleted: {reason}",
                path=path,
                reason=os_reason(error),
            )
            raise ProfileError(text, fault=DISK_REFUSES) from error

    def path(self, name: str) -> Path:
        """Return the file of a profile, which need not exist."""
        if not is_name(name):
            text = Message(
                "{name} is not a valid profile name; use 1 to {most} letters, digits, spaces, - "
                "and _; begin with a letter or digit and do not end with a space",
                name=repr(name[:64]),
                most=MAX_NAME_LENGTH,
            )
            raise ProfileError(text, fault=NOT_ALLOWED)
        return self._folder / f"{name}{SUFFIX}"


def _unreadable(path: Path, reason: Message) -> ProfileError:
    return ProfileError(
        Message(
            "the profile {path} cannot be read: {reason}; save it again", path=path, reason=reason
        ).reporting_only(faults.SETTINGS_LOST)
    )
