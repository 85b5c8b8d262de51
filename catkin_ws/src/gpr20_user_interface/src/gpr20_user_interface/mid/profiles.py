"""Parameters of a survey that are kept under a name."""

from __future__ import annotations

import dataclasses
import re
from typing import Any, Dict, List

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.records import record_from
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.errors import ProfileError
from gpr20_user_interface.low.profile_folder import ProfileFolder

MAX_NAME_LENGTH = 32
# Nothing that means something to a path: neither slash nor a dot.
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
            f"{name[:64]!r} cannot be the name of a profile; allowed are 1 to {MAX_NAME_LENGTH} "
            "letters, digits, blanks, - and _, with a letter or digit first and no blank last"
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
            return record_from(SurveyParameters, values, f"profile {name}")
        except InvalidValueError as error:
            raise ProfileError(f"{error}; save it again") from error

    def save(self, name: str, parameters: SurveyParameters) -> None:
        """Keep parameters under a name, in place of those that were there.

        Raises:
            ProfileError: The name is not allowed, or they cannot be written.
        """
        values: Dict[str, Any] = dataclasses.asdict(parameters)
        values["polarizations_deg"] = list(parameters.polarizations_deg)
        self._folder.write(check_name(name), values)

    def remove(self, name: str) -> None:
        """Forget a profile.

        Raises:
            ProfileError: It cannot be removed.
        """
        self._folder.remove(check_name(name))
