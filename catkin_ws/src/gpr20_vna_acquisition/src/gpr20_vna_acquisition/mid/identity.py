"""Whether the instrument at an address is the one that the robot is configured for."""

from __future__ import annotations

from gpr20_common.message import Message
from gpr20_vna_acquisition.errors import VnaIdentityError
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
    raise VnaIdentityError(
        Message(
            "the VNA identifies itself as {identity}; expected {maker} {model}; check its "
            "address, or the parameters maker and model",
            identity=repr(_printable(identity[:40])),
            maker=parameters.maker,
            model=parameters.model,
            details=repr(identity[:200]),
        )
    )


def _printable(text: str) -> str:
    """Return a text from the instrument for a sentence: "?" instead of what has no place in it."""
    return "".join(one if one.isascii() and one.isprintable() else "?" for one in text)
