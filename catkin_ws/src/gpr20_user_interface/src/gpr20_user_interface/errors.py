"""The errors of the user interface."""

from gpr20_common.errors import Gpr20Error


class UserInterfaceError(Gpr20Error):
    """The root of every error of this package."""


class MasterUnavailableError(UserInterfaceError, OSError):
    """There is no ROS master to ask."""


class ParametersRefusedError(UserInterfaceError, ValueError):
    """The parameters of the survey are not allowed; the message names each."""


class LanguageError(UserInterfaceError, ValueError):
    """The window cannot speak this language."""


class SurveyNotReadableError(UserInterfaceError, ValueError):
    """What is told of a survey cannot be shown; the message says why."""


class ProfileError(UserInterfaceError, ValueError):
    """A profile of parameters cannot be read, written or named so."""
