"""The errors of the screens."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_RUNNING
from gpr20_operator import faults
from gpr20_survey.faults import DAMAGED


class MasterUnavailableError(Gpr20Error, OSError):
    """There is no ROS master to ask."""

    fault = NOT_RUNNING


class DisplayUnavailableError(Gpr20Error, OSError):
    """There is no display to show the window on."""

    fault = faults.NO_DISPLAY


class SurveyNotReadableError(Gpr20Error, ValueError):
    """A survey, or a part of it, cannot be shown; the message gives the reason."""

    fault = DAMAGED


class SettingsError(Gpr20Error, ValueError):
    """What the screen remembers cannot be read or written; the message gives the reason."""

    fault = faults.SETTINGS_LOST.as_warning()
