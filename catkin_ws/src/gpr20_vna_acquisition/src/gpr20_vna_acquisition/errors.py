"""What can go wrong with the network analyzer."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import PART_SILENT
from gpr20_survey.faults import (
    NOT_CALIBRATED,
    VNA_FAILED,
    VNA_REPLACED,
    VNA_SETTINGS,
    VNA_SILENT,
    WRONG_VNA,
)
from gpr20_vna_acquisition import faults


class VnaError(Gpr20Error):
    """The network analyzer refused or failed to carry out a request."""

    fault = VNA_FAILED


class VnaConnectionError(VnaError, OSError):
    """The link to the instrument could not be made, or broke.

    Every error of the library below becomes this one. The transport that raised it is
    dead; the next exchange needs a new one.
    """

    fault = VNA_SILENT


class VnaNoAnswerError(VnaConnectionError):
    """A query got no answer in time."""


class VnaIdentityError(VnaError):
    """Something answers at the address, but it is not the expected instrument."""

    fault = WRONG_VNA


class VnaReplacedError(VnaIdentityError):
    """An instrument of the right kind answers, but not the one that was connected."""

    fault = VNA_REPLACED


class VnaNotReadyError(VnaError, RuntimeError):
    """The request needs a connection or a configuration first."""

    fault = faults.NOT_CONNECTED


class VnaSettingError(VnaError):
    """The instrument did not accept a setting, or no longer has it."""

    fault = VNA_SETTINGS


class VnaCalibrationError(VnaError):
    """The instrument's calibration is not accepted for a survey."""

    fault = NOT_CALIBRATED


class VnaSweepError(VnaError, OSError):
    """A sweep did not end in time, or every attempt failed."""


class VnaTimeoutError(VnaError, TimeoutError):
    """A request, with all its retries, exceeded its time limit."""

    fault = VNA_SILENT


class VnaClosedError(VnaError, RuntimeError):
    """The driver is shutting down."""

    fault = PART_SILENT


class VnaDataError(VnaError, ValueError):
    """An answer of the instrument is invalid."""


class VnaOldDataError(VnaDataError):
    """Data, or a part of them, are those of a sweep before."""
