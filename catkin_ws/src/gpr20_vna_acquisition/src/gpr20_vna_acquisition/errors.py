"""What can go wrong with the network analyzer."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import PART_SILENT
from gpr20_common.message import Fault, Message
from gpr20_survey.faults import (
    NOT_CALIBRATED,
    VNA_FAILED,
    VNA_REPLACED,
    VNA_SETTINGS,
    VNA_SILENT,
    WRONG_VNA,
)

LOCKED = Fault(
    "vna.locked",
    Message(
        "Close the other program that uses the VNA. If there is none, switch the VNA off and on."
    ),
)
NOT_CONNECTED = Fault(
    "vna.not_connected",
    Message("Start or resume a survey, or test the VNA on ROBOT: that connects it and sets it up."),
)


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

    fault = NOT_CONNECTED


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


def replaced(now: str, former: str) -> VnaReplacedError:
    """Return the error of an instrument that is another one, on the same link."""
    return VnaReplacedError(
        Message(
            "the VNA is now {now} and was {former}; connect the former VNA again, or accept the "
            "other one when you connect or resume",
            now=repr(now[:80]),
            former=repr(former[:80]),
        )
    )


def not_connected() -> VnaNotReadyError:
    """Return the error of a request that needs a connection first."""
    return VnaNotReadyError(
        Message("the VNA is not connected; connect it first", details="service connection")
    )


def not_configured() -> VnaNotReadyError:
    """Return the error of a request that needs a configured sweep first."""
    return VnaNotReadyError(
        Message(
            "the VNA's sweep is not configured; configure it first",
            details="service freq_sweep_setup",
        )
    )


def settings_refused(settings: Message) -> VnaSettingError:
    """Return the error of an instrument that does not accept these settings."""
    return VnaSettingError(
        Message(
            "the VNA did not accept a setting: {settings}; check that it is in VNA mode "
            "and not operated by hand",
            settings=settings,
        )
    )


def settings_changed(settings: Message) -> VnaSettingError:
    """Return the error of a sweep after which these settings are different."""
    return VnaSettingError(
        Message(
            "the VNA's settings were changed during the sweep: {settings}; do not operate "
            "it by hand during a survey",
            settings=settings,
        )
    )


def sweep_not_ended(points: int, limit_s: float) -> VnaSweepError:
    """Return the error of a sweep that did not end within a time limit [s]."""
    return VnaSweepError(
        Message(
            "the sweep of {points} points did not end within {limit_s:.3g} s; check that "
            "the VNA is in VNA mode and not operated by hand",
            points=points,
            limit_s=limit_s,
        ),
        fault=VNA_SETTINGS,
    )


def old_data() -> VnaOldDataError:
    """Return the error of data that are not all new."""
    return VnaOldDataError(
        Message("the VNA gave data of which a part is that of the previous sweep")
    )
