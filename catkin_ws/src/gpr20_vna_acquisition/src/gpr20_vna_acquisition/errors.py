"""What can go wrong with the network analyzer."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class VnaError(Gpr20Error):
    """The network analyzer refused or failed to carry out a request."""


class VnaConnectionError(VnaError, OSError):
    """The link to the instrument could not be made, or broke.

    Every error of the library below becomes this one. The transport that raised it is
    dead; the next exchange needs a new one.
    """


class VnaNoAnswerError(VnaConnectionError):
    """A query got no answer in time."""


class VnaIdentityError(VnaError):
    """Something answers at the address, but it is not the expected instrument."""


class VnaReplacedError(VnaIdentityError):
    """An instrument of the right kind answers, but not the one that was connected."""


class VnaNotReadyError(VnaError, RuntimeError):
    """The request needs a connection or a configuration first."""


class VnaSettingError(VnaError):
    """The instrument did not accept a setting, or no longer has it."""


class VnaCalibrationError(VnaError):
    """The instrument's calibration is not accepted for a survey."""


class VnaSweepError(VnaError, OSError):
    """A sweep did not end in time, or every attempt failed."""


class VnaTimeoutError(VnaError, TimeoutError):
    """A request, with all its retries, exceeded its time limit."""


class VnaClosedError(VnaError, RuntimeError):
    """The driver is shutting down."""


class VnaDataError(VnaError, ValueError):
    """An answer of the instrument is invalid."""


class VnaOldDataError(VnaDataError):
    """Data, or a part of them, are those of a sweep before."""


class VnaLibraryError(VnaError, ImportError):
    """A library that this kind of analyzer needs is not installed, or too old."""
