"""The errors of the user interface."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_operator import faults


class UserInterfaceError(Gpr20Error):
    """The root of every error of this package."""

    fault = faults.NO_CONTROL


class MasterUnavailableError(UserInterfaceError, OSError):
    """There is no ROS master to ask."""

    fault = faults.NO_MASTER


class DisplayUnavailableError(UserInterfaceError, OSError):
    """There is no display to show the window on."""

    fault = faults.NO_DISPLAY


class ParametersRefusedError(UserInterfaceError, ValueError):
    """The parameters of the survey are not allowed; the message names each."""

    fault = faults.PARAMETERS_REFUSED


class SurveyNotReadableError(UserInterfaceError, ValueError):
    """A survey, or a part of it, cannot be shown; the message gives the reason."""

    fault = faults.SURVEY_UNREADABLE


class ProfileError(UserInterfaceError, ValueError):
    """A profile of parameters cannot be read or written, or its name is not allowed."""

    fault = faults.PROFILE_UNREADABLE


class SettingsError(UserInterfaceError, ValueError):
    """The settings of the window cannot be read or written; the message gives the reason."""

    fault = faults.SETTINGS_DAMAGED
