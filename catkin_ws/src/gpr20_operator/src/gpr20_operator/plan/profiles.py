"""Parameters of a survey that are stored under a name."""

from __future__ import annotations

import dataclasses
import re
from typing import Any, Dict, List

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.records import record_from
from gpr20_operator import faults
from gpr20_operator.errors import ProfileError
from gpr20_operator.files.profile_folder import ProfileFolder
from gpr20_survey.plan.survey_parameters import SurveyParameters

MAX_NAME_LENGTH = 32
# Nothing with a meaning in a path: neither slash nor dot.
NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9 _-]{{0,{MAX_NAME_LENGTH - 1}}}")


def is_name(name: str) -> bool:
    """Return whether a text may become the name of a profile and of its file."""
    return NAME.fullmatch(name) is not None and name == name.strip()


def check_name(name: str) -> str:
    """Return a name that may become that of a file.

    Raises:
        ProfileError: It may not.
    """
    if not is_name(name):
        raise ProfileError(
            Message(
                "{name} is not a valid profile name; use 1 to {most} letters, digits, spaces, - "
                "and _; begin with a letter or digit and do not end with a space",
                name=repr(name[:64]),
                most=MAX_NAME_LENGTH,
            ),
            fault=faults.PROFILE_NAME,
        )
    return name


class Profiles:
    """Parameters by name; checks every name and every value."""

    def __init__(self, folder: ProfileFolder) -> None:
        self._folder = folder

    def names(self) -> List[str]:
        """Return the names of all profiles, sorted.

        Raises:
            ProfileError: They cannot be listed.
        """
        return [name for name in self._folder.names() if is_name(name)]

    def load(self, name: str) -> SurveyParameters:
        """Return the parameters of a profile; whether this robot allows them is not checked.

        Raises:
            ProfileError: It is not there or is no profile.
        """
        values = self._folder.read(check_name(name))
        try:
            return record_from(SurveyParameters, values, f"{name}.yaml")
        except InvalidValueError as error:
            raise ProfileError(
                Message("{reason}; save the profile again", reason=error.message)
            ) from error

    def save(self, name: str, parameters: SurveyParameters) -> None:
        """Store parameters under a name; they replace those that were there.

        Raises:
            ProfileError: The name is not allowed, or they cannot be written.
        """
        values: Dict[str, Any] = dataclasses.asdict(parameters)
        values["polarizations_deg"] = list(parameters.polarizations_deg)
        self._folder.write(check_name(name), values)

    def remove(self, name: str) -> None:
        """Delete a profile.

        Raises:
            ProfileError: It cannot be deleted.
        """
        self._folder.remove(check_name(name))
