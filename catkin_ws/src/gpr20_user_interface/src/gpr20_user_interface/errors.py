"""The errors of the user interface."""

from gpr20_common.errors import Gpr20Error


class UserInterfaceError(Gpr20Error):
    """The root of every error of this package."""


class MasterUnavailableError(UserInterfaceError, OSError):
    """There is no ROS master to ask."""


class DisplayUnavailableError(UserInterfaceError, OSError):
    """There is no display to show the window on."""


class ParametersRefusedError(UserInterfaceError, ValueError):
    """The parameters of the survey are not allowed; the message names each."""


class SurveyNotReadableError(UserInterfaceError, ValueError):
    """A survey, or a part of it, cannot be shown; the message gives the reason."""


class ProfileError(UserInterfaceError, ValueError):
    """A profile of parameters cannot be read or written, or its name is not allowed."""


class SettingsError(UserInterfaceError, ValueError):
    """The settings of the window cannot be read or written; the message gives the reason."""
