"""What can go wrong with the network analyzer."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error


class VnaError(Gpr20Error):
    """The network analyzer refused or failed to do what it was told."""


class VnaConnectionError(VnaError, OSError):
    """The link to the instrument could not be made, or broke.

    Whatever the library below raises becomes this one. The transport that raised it is
    dead; only a new one can go on.
    """


class VnaIdentityError(VnaError):
    """Something answers at the address, but it is not the expected instrument."""


class VnaNotReadyError(VnaError, RuntimeError):
    """The driver was asked for something that needs a connection or a configuration first."""


class VnaSettingError(VnaError):
    """The instrument did not take a setting, or no longer has it."""


class VnaCalibrationError(VnaError):
    """The instrument's calibration is none with which a survey may be made."""


class VnaSweepError(VnaError, OSError):
    """A sweep did not end in time, or none of several attempts gave a good one."""


class VnaTimeoutError(VnaError, TimeoutError):
    """A request took longer than it may, with all its repetitions."""


class VnaClosedError(VnaError, RuntimeError):
    """The driver is being shut down."""


class VnaDataError(VnaError, ValueError):
    """An answer of the instrument is not what it must be."""
