"""The errors that every kind of analyzer has in common."""

from __future__ import annotations

from gpr20_common.message import Message
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaNotReadyError,
    VnaOldDataError,
    VnaSettingError,
    VnaSweepError,
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
        ),
        fault=faults.NOT_CONNECTED,
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
        ),
        fault=VNA_SETTINGS,
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


def data_changed() -> VnaOldDataError:
    """Return the error of data that were no longer shown when they were read again."""
    return VnaOldDataError(
        Message(
            "the VNA's data changed after they were read; its display followed the end of the "
            "sweep late"
        )
    )


def old_data() -> VnaOldDataError:
    """Return the error of data that are not all new."""
    return VnaOldDataError(
        Message("the VNA gave data of which a part is that of the previous sweep")
    )
