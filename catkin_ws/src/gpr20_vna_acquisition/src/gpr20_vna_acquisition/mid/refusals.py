"""The errors that every kind of analyzer has in common."""

from __future__ import annotations

from gpr20_common.message import Message
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_vna_acquisition.errors import (
    VnaIdentityError,
    VnaNotReadyError,
    VnaOldDataError,
    VnaReplacedError,
    VnaSettingError,
    VnaSweepError,
)
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# Maker, model, serial number, firmware (IEEE 488.2, *IDN?).
IDENTITY_FIELDS = 4


def check_identity(identity: str, parameters: VnaParameters) -> None:
    """Compare maker and model; what follows a slash in the model is an option.

    Raises:
        VnaIdentityError: They are not those of the configuration.
    """
    fields = [field.strip() for field in identity.split(",")]
    model = fields[1].split("/")[0] if len(fields) >= IDENTITY_FIELDS else ""
    if (fields[0], model) == (parameters.maker, parameters.model):
        return
    shown = "".join(one if one.isascii() and one.isprintable() else "?" for one in identity[:40])
    raise VnaIdentityError(
        Message(
            "the VNA identifies itself as {identity}; expected {maker} {model}; check its "
            "address, or the parameters maker and model",
            identity=repr(shown),
            maker=parameters.maker,
            model=parameters.model,
            details=repr(identity[:200]),
        )
    )


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
